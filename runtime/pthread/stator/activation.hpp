// What is noted of each activation while it runs: its counts, and its times for `top`.
// STATOR_COUNTERS switches the times on.
#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>

#include "stator/task.hpp"

namespace stator {

uint64_t clock_us();
uint64_t thread_cpu_ns();

// Counters are written by their level's thread alone and read by the monitor's. Relaxed: each is a
// figure of its own, and nothing is read because of it.
inline void note(uint32_t& counter, uint32_t value) {
    __atomic_store_n(&counter, value, __ATOMIC_RELAXED);
}
inline void add_to_counter(uint32_t& counter, uint32_t more) {
    note(counter, counter + more);
}

#ifdef STATOR_COUNTERS
// Lives as long as an activation. Its time is the thread's CPU time, in nanoseconds: the clock runs
// on while a more urgent level has the processor, this one does not. docs/link.md has the costs.
class Activation {
  public:
    Activation(uint32_t, TaskCounters& counters)
        : counters_(counters), begin_ns_(thread_cpu_ns()) {}
    void finish() {
        constexpr uint64_t kMax = std::numeric_limits<uint32_t>::max();
        const auto own_ns = static_cast<uint32_t>(std::min(thread_cpu_ns() - begin_ns_, kMax));
        add_to_counter(counters_.ticks, own_ns);
        note(counters_.last_ticks, own_ns);
        if (own_ns > counters_.most_ticks) note(counters_.most_ticks, own_ns);
    }
    // Where the graph has a deadline, or a chain ends.
    void finish(uint64_t now_us) {
        finish();
        const auto late_us = static_cast<uint32_t>(clock_us() - now_us);
        if (late_us > counters_.latest_us) note(counters_.latest_us, late_us);
    }

  private:
    TaskCounters& counters_;
    uint64_t begin_ns_;
};
#else
struct Activation {
    Activation(uint32_t, TaskCounters&) {}
    void finish() {}
    void finish(uint64_t) {}
};
#endif

}  // namespace stator
