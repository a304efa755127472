// Keeps the parameters that differ from the graph's as records, and takes them back after a start.
#include "keeper.hpp"

#include <cstring>

#include "validity.hpp"

namespace stator::apps::parameters {

namespace {

// The data of a record.
struct Kept {
    ParameterBits value;
    uint32_t definition;
};
static_assert(sizeof(Kept) <= sizeof(StoredRecord::data));

bool is_record_kept(const RecordKept& kept) {
    return kept.result == RecordKept::Result::kKept;
}

unsigned row_of(const ParameterPort& parameters, uint32_t key) {
    const auto rows = parameters.rows();
    for (unsigned i = 0; i < rows.size(); ++i) {
        if (rows[i].is.key == key) return i;
    }
    return Marks::kMost;
}

}  // namespace

unsigned Marks::next(unsigned from) const {
    if (count_ == 0) return kMost;
    for (unsigned i = 0; i < kMost; ++i) {
        const unsigned at = (from + i) % kMost;
        if (has(at)) return at;
    }
    return kMost;
}

void Keeper::take(ParametersPorts& ports) {
    if (ports.stored.next()) take_record(ports, *ports.stored);
    if (!ports.kept.next()) return;
    const RecordKept& kept = *ports.kept;
    const bool is_ours = kept.kind == RecordKept::Kind::kParameter && kept.key == pending_.key;
    if (is_ours && pending_.row != kNone) conclude(is_record_kept(kept));
}

void Keeper::take_record(ParametersPorts& ports, const StoredRecord& record) {
    if (record.kind != StoredRecord::Kind::kParameter) return;
    const unsigned row = row_of(ports.parameters, record.key);
    if (row != kNone) return apply(ports, row, record, false);
    const auto former = ports.parameters.former();
    for (unsigned i = 0; i < former.size(); ++i) {
        if (former[i].key != record.key) continue;
        if (record.length == 0 || stored_.has(former[i].row)) {
            former_.set(i, record.length != 0);
        } else {
            apply(ports, former[i].row, record, true);
            former_.set(i, waiting_.has(former[i].row));
        }
        return;
    }
    if (record.length != 0) ++counts_.unknown;
}

void Keeper::apply(ParametersPorts& ports, unsigned row, const StoredRecord& record,
                   bool is_former) {
    const ParameterRow& parameter = ports.parameters.rows()[row];
    Kept kept{.value = parameter.standard, .definition = parameter.is.definition};
    if (record.length == sizeof kept) std::memcpy(&kept, record.data.data(), sizeof kept);
    const bool is_length = record.length == sizeof kept || record.length == 0;
    if (!is_former) stored_.set(row, record.length != 0);
    if (!is_length || kept.definition != parameter.is.definition || parameter.is_fixed) {
        return leave(row, counts_.redefined);
    }
    if (!is_in_range(parameter, kept.value)) return leave(row, counts_.out_of_range);
    const bool is_withheld = ports.memory && ports.memory->short_lives >= kMaxShortLives;
    if (is_withheld) return leave(row, counts_.withheld);
    if (asked_.has(row)) return;
    waiting_.set(row, is_former);
    if (kept.value != ports.parameters.value(parameter)) {
        ports.parameters.publish(parameter, kept.value);
    }
}

// The record stays, and does not count.
void Keeper::leave(unsigned row, uint16_t& count) {
    ++count;
    for (auto& unused : counts_.unused) {
        if (unused != 0) continue;
        unused = static_cast<uint16_t>(row + 1);
        return;
    }
}

void Keeper::change(const ParametersPorts& ports, unsigned row) {
    if (!ports.memory) return;
    asked_.set(row);
    waiting_.set(row);
    refused_.set(row, false);
}

void Keeper::work(ParametersPorts& ports) {
    if (pending_.row != kNone && ports.now >= pending_.until_us) conclude(false);
    const auto state = ports.memory ? ports.memory->state : NonvolatileStatus::State::kLoading;
    if (state == NonvolatileStatus::State::kLoaded && pending_.row == kNone) publish_next(ports);
    while (state == NonvolatileStatus::State::kFailed && waiting_.count() != 0) {
        const unsigned row = waiting_.next(0);
        waiting_.set(row, false);
        refused_.set(row);
    }
    report(ports);
}

void Keeper::conclude(bool is_kept) {
    const unsigned row = pending_.row;
    pending_.row = kNone;
    tries_ = is_kept ? 0 : tries_ + 1;
    const bool gives_up = tries_ == kMaxTries;
    if (gives_up) tries_ = 0;
    if (pending_.is_former) {
        if (is_kept || gives_up) former_.set(row, false);
    } else if (is_kept) {
        stored_.set(row, !pending_.is_removal);
    } else if (!gives_up) {
        waiting_.set(row);
    } else if (!waiting_.has(row)) {
        refused_.set(row);
    }
}

void Keeper::publish_next(ParametersPorts& ports) {
    while (waiting_.count() != 0) {
        const unsigned row = waiting_.next(next_);
        const ParameterRow& parameter = ports.parameters.rows()[row];
        const Kept kept{.value = ports.parameters.value(parameter),
                        .definition = parameter.is.definition};
        const bool is_removal = kept.value == parameter.standard;
        waiting_.set(row, false);
        next_ = row + 1;
        if (is_removal && !stored_.has(row)) continue;
        pending_ = {.row = row, .key = parameter.is.key, .is_removal = is_removal};
        StoredRecord record{.key = parameter.is.key, .kind = StoredRecord::Kind::kParameter};
        if (!is_removal) {
            record.length = sizeof kept;
            std::memcpy(record.data.data(), &kept, sizeof kept);
        }
        return publish(ports, record);
    }
    const unsigned former = former_.next(0);
    if (former == kNone) return;
    const uint32_t key = ports.parameters.former()[former].key;
    pending_ = {.row = former, .key = key, .is_removal = true, .is_former = true};
    publish(ports, {.key = key, .kind = StoredRecord::Kind::kParameter});
}

void Keeper::publish(ParametersPorts& ports, const StoredRecord& record) {
    pending_.until_us = ports.now + kResultTime_us;
    ports.store.publish([&] { return record; });
}

void Keeper::report(ParametersPorts& ports) {
    counts_.count = static_cast<uint16_t>(ports.parameters.rows().size());
    counts_.stored = stored_.count();
    counts_.pending = static_cast<uint16_t>(waiting_.count() + (pending_.row != kNone ? 1 : 0));
    counts_.refused = refused_.count();
    if (ports.memory) {
        const auto of_memory = static_cast<unsigned>(ports.memory->state);
        counts_.state = static_cast<ParameterStatus::State>(of_memory + 1);
    }
    if (has_reported_ && std::memcmp(&counts_, &reported_, sizeof counts_) == 0) return;
    has_reported_ = true;
    reported_ = counts_;
    ports.report.publish([&] { return counts_; });
}

}  // namespace stator::apps::parameters
