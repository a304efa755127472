// What is noted of each activation while it runs: nothing yet but its count.
#pragma once

#include <cstdint>

#include "stator/task.hpp"

namespace stator {

struct Activation {
    Activation(uint32_t, TaskCounters&) {}
    void finish() {}
    void finish(uint64_t) {}
};

// The monitor reads it from another thread.
inline void count_activation(uint32_t& activations) {
    __atomic_store_n(&activations, activations + 1, __ATOMIC_RELAXED);
}

}  // namespace stator
