// What drivers of nonvolatile memories have in common: first all records are loaded and published,
// a few in each activation; then what comes is kept, one record in each. The memory is the port of
// record_store.hpp.
#pragma once

#include <cstring>

#include "key_keeper.hpp"
#include "nonvolatile_ports.hpp"
#include "record_store.hpp"

namespace stator::drivers::nonvolatile {

template <class Port>
class NonvolatileDriver {
  public:
    explicit NonvolatileDriver(Port port) : store_(port) {}

    // `key`: of the lines; null: the board has none that sign.
    void step(NonvolatilePorts& ports, mav::SharedKey* key) {
        if (first_us_ == kNever) first_us_ = ports.now;
        if (key != nullptr && state_ == State::kLoading) key->expect();
        if (!is_counted_) {
            count_start();
        } else if (state_ == State::kLoading) {
            load(ports);
        } else if (key == nullptr || !keep_key(*key)) {
            keep(ports);
        }
        if (key != nullptr && state_ != State::kLoading && !is_key_shared_) {
            key_.share(*key);
            is_key_shared_ = true;
        }
        report(ports);
    }
    const NonvolatileStatus& status() const { return status_; }

  private:
    using State = NonvolatileStatus::State;
    using Store = RecordStore<Port>;
    static constexpr unsigned kLoads = 4;     // in an activation: the burst of the output
    static constexpr unsigned kMaxTries = 5;  // of one slot, in as many activations
    static constexpr uint64_t kShortLife_us = 5'000'000;
    static constexpr uint64_t kNever = UINT64_MAX;

    // Before any record is published: what one of them does to a node may end this life.
    void count_start() {
        unsigned short_lives = 0;
        is_counted_ = store_.count_start(short_lives);
        if (!is_counted_) {
            if (++tries_ == kMaxTries) fail();
            return;
        }
        tries_ = 0;
        short_lives_ = static_cast<uint8_t>(std::min(short_lives, 255U));
        is_young_ = true;
    }
    void fail() {
        state_ = State::kFailed;
        is_counted_ = true;
    }
    void grow_up() {
        if (is_young_) is_young_ = !store_.forget_starts() && ++tries_ < kMaxTries;
    }

    void load(NonvolatilePorts& ports) {
        StoredRecord record{};
        for (unsigned i = 0; i < kLoads && !store_.is_loaded(); ++i) {
            const auto result = store_.load_next(record);
            if (result == Store::Load::kFailed) {
                if (++tries_ == kMaxTries) fail();
                return;
            }
            tries_ = 0;
            if (result != Store::Load::kRecord) continue;
            if (record.kind == StoredRecord::Kind::kSigningKey) {
                key_.take(record);
            } else {
                ports.stored.publish([&] { return record; });
            }
        }
        if (store_.is_loaded()) state_ = State::kLoaded;
    }

    // One record of it. False: there is none to keep.
    bool keep_key(const mav::SharedKey& key) {
        if (state_ != State::kLoaded) return false;
        const auto record = key_.next(key);
        if (!record) return false;
        if (store_.keep(*record) == Store::Keep::kKept) {
            tries_ = 0;
            key_.go_on();
        } else if (++tries_ == kMaxTries) {
            tries_ = 0;
            ++refused_;
            key_.give_up();
        }
        return true;
    }

    void keep(NonvolatilePorts& ports) {
        if (ports.now - first_us_ >= kShortLife_us && state_ == State::kLoaded) grow_up();
        if (!ports.store.next()) return;
        lost_ += ports.store.lost();
        const StoredRecord& record = *ports.store;
        const bool is_possible =
            state_ == State::kLoaded && record.kind != StoredRecord::Kind::kSigningKey;
        const auto result = is_possible ? store_.keep(record) : Store::Keep::kFailed;
        if (result == Store::Keep::kKept) {
            grow_up();  // the next start has other records than this one
        } else {
            ++refused_;
        }
        ports.kept.publish([&] {
            return RecordKept{.key = record.key,
                              .kind = static_cast<RecordKept::Kind>(record.kind),
                              .result = static_cast<RecordKept::Result>(result)};
        });
    }

    void report(NonvolatilePorts& ports) {
        const NonvolatileStatus status{.refused = refused_,
                                       .lost = lost_,
                                       .records = static_cast<uint16_t>(store_.records()),
                                       .most_records = Store::kMaxRecords,
                                       .mended = static_cast<uint16_t>(store_.mended()),
                                       .damaged = static_cast<uint16_t>(store_.damaged()),
                                       .state = state_,
                                       .short_lives = short_lives_};
        if (std::memcmp(&status, &status_, sizeof status) == 0) return;
        status_ = status;
        ports.status.publish([&] { return status; });
    }

    Store store_;
    KeyKeeper key_;
    bool is_key_shared_ = false;
    State state_ = State::kLoading;
    unsigned tries_ = 0;
    uint64_t first_us_ = kNever;  // activation
    bool is_counted_ = false;     // this start
    bool is_young_ = false;       // and counted as one that does not live long
    uint8_t short_lives_ = 0;
    uint32_t refused_ = 0;
    uint32_t lost_ = 0;
    NonvolatileStatus status_{};  // as published
};

}  // namespace stator::drivers::nonvolatile
