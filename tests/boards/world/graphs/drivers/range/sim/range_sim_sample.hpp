// One sample of the simulated range finder: from the world to the driver.
#pragma once

#include <cstdint>

namespace stator::drivers::range::sim {

struct RangeSimSample {
    uint64_t timestamp_sample = 0;  // us
    float distance = 0.0F;          // m
};

}  // namespace stator::drivers::range::sim
