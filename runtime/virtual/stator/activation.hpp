// What is noted of each activation while it runs: nothing, as it takes no time of its own here.
#pragma once

#include <cstdint>

namespace stator {

struct Activation {
    explicit Activation(uint32_t) {}
};

inline void count_activation(uint32_t& activations) {
    ++activations;
}

}  // namespace stator
