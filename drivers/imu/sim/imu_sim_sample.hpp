// One sample of the simulated IMU: from the world to the driver.
#pragma once

#include <array>
#include <cstdint>
#include <span>

namespace stator::drivers::imu::sim {

struct ImuSimSample {
    uint64_t timestamp_sample = 0;   // us
    std::array<float, 3> gyro_B{};   // rad/s
    std::array<float, 3> accel_B{};  // m/s^2, specific force

    // For faults.
    template <class Visit>
    void each_quantity(Visit&& visit) {
        visit("gyro", std::span<float>(gyro_B));
        visit("accel", std::span<float>(accel_B));
    }
};

}  // namespace stator::drivers::imu::sim
