// What is noted of each activation while it runs: nothing yet but its count.
#pragma once

#include <cstdint>

namespace stator {

struct Activation {
    explicit Activation(uint32_t) {}
};

// The monitor reads it from another thread.
inline void count_activation(uint32_t& activations) {
    __atomic_store_n(&activations, activations + 1, __ATOMIC_RELAXED);
}

}  // namespace stator
