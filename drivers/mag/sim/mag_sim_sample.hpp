// One sample of the simulated magnetometer: from the world to the driver.
#pragma once

#include <array>
#include <cstdint>
#include <span>

namespace stator::drivers::mag::sim {

struct MagSimSample {
    uint64_t timestamp_sample = 0;  // us
    std::array<float, 3> field_B_gauss{};

    // For faults.
    template <class Visit>
    void each_quantity(Visit&& visit) {
        visit("field", std::span<float>(field_B_gauss));
    }
};

}  // namespace stator::drivers::mag::sim
