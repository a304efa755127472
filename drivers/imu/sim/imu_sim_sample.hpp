// One sample of the simulated IMU: from the world to the driver.
#pragma once

#include <array>
#include <cstdint>

namespace stator::drivers::imu::sim {

struct ImuSimSample {
    uint64_t timestamp_sample = 0;   // us
    std::array<float, 3> gyro_B{};   // rad/s
    std::array<float, 3> accel_B{};  // m/s^2, specific force
};

}  // namespace stator::drivers::imu::sim
