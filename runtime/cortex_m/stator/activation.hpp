// What is noted of each activation while it runs: its time, for `top`, and a ring of the newest
// ones for the record of a fault. STATOR_COUNTERS switches it on.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>

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
    std::atomic<uint32_t> count{0};  // modulo 2^32
    // Time that tasks took from those that they interrupted, in ticks modulo 2^32.
    std::atomic<uint32_t> stolen_ticks{0};
};
extern ActivationRing activation_ring;

#ifdef STATOR_COUNTERS
// Lives as long as an activation. Context: the wrapper of a task.
class Activation {
  public:
    Activation(uint32_t task, TaskCounters& counters) : counters_(counters) {
        const uint32_t begin = board::ticks();
        own_begin_ = begin - activation_ring.stolen_ticks.load(std::memory_order_relaxed);
        // Exact although higher levels preempt it: an exclusive load and store, which the hardware
        // fails after an exception.
        const uint32_t number = activation_ring.count.fetch_add(1, std::memory_order_relaxed);
        activation_ring.entries[number % activation_ring.entries.size()] = (begin << 8) | task;
    }
    // In this order a task that comes between two lines counts as this one's, not less than
    // nothing.
    void finish() {
        const uint32_t stolen = activation_ring.stolen_ticks.load(std::memory_order_relaxed);
        const uint32_t all = board::ticks() - own_begin_;
        activation_ring.stolen_ticks.store(all, std::memory_order_relaxed);
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
