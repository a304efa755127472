// What is noted of each activation while it runs: its time, for `top`, and a ring of the newest
// ones for the record of a fault. STATOR_COUNTERS switches it on.
#pragma once

#include <array>
#include <cstdint>

#include "stator/exclusive_word.hpp"
#include "stator/task.hpp"

namespace stator {

namespace board {
uint32_t timer_us();
uint32_t ticks();
}  // namespace board

// Of all levels; an entry is the time in ticks modulo 2^24, and the task's index in the
// lowest byte.
struct ActivationRing {
    std::array<uint32_t, 32> entries{};
    ExclusiveWord count;  // modulo 2^32
    // Time that tasks took from those that they interrupted, in ticks modulo 2^32.
    RelaxedWord stolen_ticks;
};
extern ActivationRing activation_ring;

#ifdef STATOR_COUNTERS
// Lives as long as an activation. Context: the wrapper of a task.
class Activation {
  public:
    Activation(uint32_t task, TaskCounters& counters) : counters_(counters) {
        uint32_t number = 0;
        uint32_t begin = 0;
        // Its number, and the time with what was stolen until then, are of one moment: else the
        // time of a task that came between the two readings would be taken from others twice.
        do {
            number = activation_ring.count.load_exclusive();
            const uint32_t stolen = activation_ring.stolen_ticks.load();
            begin = board::ticks();
            own_begin_ = begin - stolen;
        } while (!activation_ring.count.store_exclusive(number + 1));
        activation_ring.entries[number % activation_ring.entries.size()] = (begin << 8) | task;
    }
    // In this order a task that comes between two lines counts as this one's, not less than
    // nothing.
    void finish() {
        const uint32_t stolen = activation_ring.stolen_ticks.load();
        const uint32_t all = board::ticks() - own_begin_;
        activation_ring.stolen_ticks.store(all);
        const uint32_t own = all - stolen;
        counters_.ticks += own;
        counters_.last_ticks = own;
        if (own > counters_.most_ticks) counters_.most_ticks = own;
    }
    // Where the graph has a deadline, or a chain ends.
    void finish(uint64_t now_us) {
        finish();
        const uint32_t late_us = board::timer_us() - static_cast<uint32_t>(now_us);
        if (late_us > counters_.latest_us) counters_.latest_us = late_us;
    }

  private:
    TaskCounters& counters_;
    uint32_t own_begin_;
};
#else
struct Activation {
    Activation(uint32_t, TaskCounters&) {}
    void finish() {}
    void finish(uint64_t) {}
};
#endif

inline void add_to_counter(uint32_t& counter, uint32_t more) {
    counter += more;
}

}  // namespace stator
