// The IMU of a simulated board: publishes what the board measured.
#pragma once

#include <array>
#include <cstdint>

#include "imu_ports.hpp"

namespace stator::drivers::imu::sim {

class ImuSim {
  public:
    // The registers of the part. The board writes a sample, then raises data_ready; the next
    // sample overwrites one that has not been read.
    struct Device {
        uint64_t timestamp_sample = 0;   // us
        std::array<float, 3> gyro_B{};   // rad/s
        std::array<float, 3> accel_B{};  // m/s^2, specific force
    };

    explicit ImuSim(Device& device) : device_(device) {}
    void step(ImuPorts& ports);

  private:
    Device& device_;
};

}  // namespace stator::drivers::imu::sim
