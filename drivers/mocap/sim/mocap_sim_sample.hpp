// One measurement of the simulated motion capture: from the world to the driver.
#pragma once

#include <array>
#include <cstdint>
#include <span>

namespace stator::drivers::mocap::sim {

struct MocapSimSample {
    uint64_t timestamp_sample = 0;      // us, of the picture, not of its arrival
    std::array<float, 3> position_N{};  // m
    float yaw = 0.0F;                   // rad

    // For faults.
    template <class Visit>
    void each_quantity(Visit&& visit) {
        visit("position", std::span<float>(position_N));
        visit("yaw", std::span<float>(&yaw, 1));
    }
};

}  // namespace stator::drivers::mocap::sim
