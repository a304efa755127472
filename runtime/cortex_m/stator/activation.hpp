// What is noted of each activation while it runs: a ring of the newest ones, for the record of a
// fault. STATOR_COUNTERS switches it on.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>

#include "stator/task.hpp"

namespace stator {

namespace board {
uint32_t timer_us();
}

// Of all levels; an entry is the time in us modulo 2^24, and the task's index in the lowest byte.
struct ActivationRing {
    std::array<uint32_t, 32> entries{};
    std::atomic<uint32_t> count{0};  // modulo 2^32
};
extern ActivationRing activation_ring;

#ifdef STATOR_COUNTERS
// Lives as long as an activation. Context: the wrapper of a task.
class Activation {
  public:
    explicit Activation(uint32_t task) {
        // Exact although higher levels preempt it: an exclusive load and store, which the hardware
        // fails after an exception.
        const uint32_t number = activation_ring.count.fetch_add(1, std::memory_order_relaxed);
        activation_ring.entries[number % activation_ring.entries.size()] =
            (board::timer_us() << 8) | task;
    }
};
#else
struct Activation {
    explicit Activation(uint32_t) {}
};
#endif

inline void count_activation(uint32_t& activations) {
    ++activations;
}

}  // namespace stator
