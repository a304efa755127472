// The order of activations does not matter as long as each finds what it took: they run by time,
// the more urgent level first, and one that needs a sample that is not there yet has it made
// before.
#include "run.hpp"

#include <algorithm>
#include <cstring>

#include "stator/host.hpp"
#include "stator/running.hpp"
#include "stator/sample_hash.hpp"

namespace stator::replay {

// --- what an activation sees ---

Job::Item* Job::next_item(unsigned tag) {
    for (Item& item : items_) {
        if (item.is_used || item.tag != tag) continue;
        item.is_used = true;
        return &item;
    }
    return nullptr;
}

Taken Job::take(unsigned tag) {
    const Item* item = next_item(tag);
    if (item == nullptr) return {};
    const Port& port = replay_->recording_.tasks[task_].ports[tag - 1];
    return {replay_->sample(port.topic, item->number), item->number};
}

void Job::publish(unsigned tag, void* message, size_t bytes) {
    const Port& port = replay_->recording_.tasks[task_].ports[tag - 1];
    const Topic* row = replay_->stores_[port.topic].row;
    if (row != nullptr)
        canonicalise(static_cast<std::byte*>(message), row->floats, row->float_count);
    if (Item* item = next_item(tag)) return replay_->compare(*this, *item, port, message);
    const auto* from = static_cast<const uint8_t*>(message);
    replay_->differ({.kind = Difference::Kind::kExtra,
                     .topic = port.topic,
                     .number = replay_->tasks_[task_].numbers[tag - 1] + 1,
                     .now_us = now_us_,
                     .recorded_hash = 0,
                     .hash = sample_hash(message, bytes),
                     .recorded = {},
                     .replayed = {from, from + bytes}});
}

std::vector<std::byte> Job::first_sample(unsigned tag) {
    const Port& port = replay_->recording_.tasks[task_].ports[tag - 1];
    std::vector<std::byte> bytes(replay_->recording_.topics[port.topic].bytes);
    const void* from = replay_->sample(port.topic, 1);
    if (from != nullptr) std::memcpy(bytes.data(), from, bytes.size());
    return bytes;
}

// --- running ---

void Replay::run() {
    while (levels_[0].next != levels_[0].tasks.size()) run_head(levels_[0]);  // before all others
    while (Level* next = earliest()) run_head(*next);
}

Replay::Level* Replay::earliest() {
    Level* found = nullptr;
    uint64_t found_us = 0;
    for (size_t i = kStreams; i-- > 0;) {
        Level& level = levels_[i];
        if (level.next == level.tasks.size()) continue;
        const uint32_t task = level.tasks[level.next];
        const uint64_t now_us = tasks_[task].activations[level.seen[task]].now_us;
        if (found != nullptr && now_us >= found_us) continue;
        found = &level;
        found_us = now_us;
    }
    return found;
}

void Replay::run_head(Level& level) {
    const uint32_t task = level.tasks[level.next++];
    // It may have run already, as another task needed what it published.
    if (tasks_[task].next == level.seen[task]++) run_next(task);
}

void Replay::run_next(size_t index) {
    TaskState& task = tasks_[index];
    const Activation& activation = task.activations[task.next++];
    Reader reader(recording_.streams[recording_.tasks[index].level], activation.at);
    Job job;
    if (!read(reader, job, false) || task.run == nullptr) return;
    task.is_over = task.is_over || needs_more_than_there_is(job);
    if (!task.is_over) {
        ++activations_;
        // A task may run another, which makes what it needs.
        const char* const outer_node = running_node;
        running_node = recording_.tasks[index].name.c_str();
        newest_activation_us = job.now_us_;
        host::activations = host::activations + 1;
        task.run(job);
        running_node = outer_node;
    } else if (job.now_us_ < skipped_us_) {
        skipped_us_ = job.now_us_;
    }
    conclude(job, !task.is_over);
}

// The streams of the levels end at different times; the recording's end is no difference.
bool Replay::needs_more_than_there_is(const Job& job) const {
    for (const Job::Item& item : job.items_) {
        const Port& port = recording_.tasks[job.task_].ports[item.tag - 1];
        if (!port.is_input) continue;
        const Store& store = stores_[port.topic];
        if (item.number >= store.states.size()) return true;
        if (store.states[item.number] == State::kBeyond) return true;
        if (store.states[item.number] == State::kRecorded &&
            tasks_[store.producers[item.number]].is_over) {
            return true;
        }
    }
    return false;
}

// What was recorded and did not come again.
void Replay::conclude(Job& job, bool is_run) {
    for (const Job::Item& item : job.items_) {
        const Port& port = recording_.tasks[job.task_].ports[item.tag - 1];
        if (port.is_input || item.is_used) continue;
        State& state = stores_[port.topic].states[item.number];
        if (!is_run) {
            if (state == State::kRecorded) state = State::kBeyond;
            continue;
        }
        if (state == State::kRecorded) state = State::kMissing;
        differ({.kind = Difference::Kind::kMissing,
                .topic = port.topic,
                .number = item.number,
                .now_us = job.now_us_,
                .recorded_hash = item.hash,
                .hash = 0,
                .recorded = {},
                .replayed = {}});
    }
}

// Makes the sample if nobody has come to that yet. Null: the replay has none of that number.
const void* Replay::sample(size_t topic, uint32_t number) {
    Store& store = stores_[topic];
    if (number >= store.states.size()) return nullptr;
    TaskState& producer = tasks_[store.producers[number]];
    while (store.states[number] == State::kRecorded &&
           producer.next < producer.activations.size()) {
        run_next(store.producers[number]);
    }
    return store.states[number] == State::kMade ? slot(topic, number) : nullptr;
}

void Replay::compare(Job& job, Job::Item& item, const Port& port, const void* message) {
    const size_t bytes = recording_.topics[port.topic].bytes;
    const uint32_t hash = sample_hash(message, bytes);
    ++results_[port.topic].compared;
    uint8_t* place = slot(port.topic, item.number);
    if (hash != item.hash) {
        const auto* from = static_cast<const uint8_t*>(message);
        std::vector<uint8_t> recorded;
        if (port.is_whole) recorded.assign(place, place + bytes);
        differ({.kind = Difference::Kind::kValue,
                .topic = port.topic,
                .number = item.number,
                .now_us = job.now_us_,
                .recorded_hash = item.hash,
                .hash = hash,
                .recorded = recorded,
                .replayed = {from, from + bytes}});
    }
    if (port.is_whole) return;  // the recording's own sample stays
    std::memcpy(place, message, bytes);
    stores_[port.topic].states[item.number] = State::kMade;
}

void Replay::differ(Difference difference) {
    ++results_[difference.topic].different;
    if (!first_.has_value()) first_ = std::move(difference);
}

uint64_t Replay::until_us() const {
    uint64_t until_us = std::min(skipped_us_, recorded_until_us());
    for (size_t level = 1; level < kStreams; ++level) {
        if (recording_.has_gap[level]) until_us = std::min(until_us, end_us(level));
    }
    return until_us;
}

uint64_t Replay::recorded_until_us() const {
    uint64_t newest_us = 0;
    for (size_t level = 1; level < kStreams; ++level) {
        newest_us = std::max(newest_us, end_us(level));
    }
    return newest_us;
}

// The newest activation of a level.
uint64_t Replay::end_us(size_t level) const {
    uint64_t last_us = 0;
    for (size_t task = 0; task < tasks_.size(); ++task) {
        if (recording_.tasks[task].level != level || tasks_[task].activations.empty()) continue;
        last_us = std::max(last_us, tasks_[task].activations.back().now_us);
    }
    return last_us;
}

}  // namespace stator::replay
