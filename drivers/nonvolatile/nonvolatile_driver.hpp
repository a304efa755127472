// What drivers of nonvolatile memories have in common: first all records are loaded and published,
// a few in each activation; then what comes is kept, one record in each. The memory is the port of
// record_store.hpp.
#pragma once

#include <cstring>

#include "nonvolatile_ports.hpp"
#include "record_store.hpp"

namespace stator::drivers::nonvolatile {

template <class Port>
class NonvolatileDriver {
  public:
    explicit NonvolatileDriver(Port port) : store_(port) {}

    void step(NonvolatilePorts& ports) {
        if (state_ == State::kLoading) {
            load(ports);
        } else {
            keep(ports);
        }
        report(ports);
    }
    const NonvolatileStatus& status() const { return status_; }

  private:
    using State = NonvolatileStatus::State;
    using Store = RecordStore<Port>;
    static constexpr unsigned kLoads = 4;     // in an activation: the burst of the output
    static constexpr unsigned kMaxTries = 5;  // of one slot, in as many activations

    void load(NonvolatilePorts& ports) {
        StoredRecord record{};
        for (unsigned i = 0; i < kLoads && !store_.is_loaded(); ++i) {
            const auto result = store_.load_next(record);
            if (result == Store::Load::kFailed) {
                if (++tries_ == kMaxTries) state_ = State::kFailed;
                return;
            }
            tries_ = 0;
            if (result == Store::Load::kRecord) ports.stored.publish([&] { return record; });
        }
        if (store_.is_loaded()) state_ = State::kLoaded;
    }

    void keep(NonvolatilePorts& ports) {
        if (!ports.store.next()) return;
        lost_ += ports.store.lost();
        const bool is_kept =
            state_ == State::kLoaded && store_.keep(*ports.store) == Store::Keep::kKept;
        if (!is_kept) ++refused_;
    }

    void report(NonvolatilePorts& ports) {
        const NonvolatileStatus status{.refused = refused_,
                                       .lost = lost_,
                                       .records = static_cast<uint16_t>(store_.records()),
                                       .most_records = Store::kMaxRecords,
                                       .mended = static_cast<uint16_t>(store_.mended()),
                                       .damaged = static_cast<uint16_t>(store_.damaged()),
                                       .state = state_};
        if (std::memcmp(&status, &status_, sizeof status) == 0) return;
        status_ = status;
        ports.status.publish([&] { return status; });
    }

    Store store_;
    State state_ = State::kLoading;
    unsigned tries_ = 0;
    uint32_t refused_ = 0;
    uint32_t lost_ = 0;
    NonvolatileStatus status_{};  // as published
};

}  // namespace stator::drivers::nonvolatile
