// What is noted of each activation while it runs: nothing yet but its count.
#pragma once

#include <cstdint>

namespace stator {

struct Activation {
    explicit Activation(uint32_t) {}
};

}  // namespace stator
