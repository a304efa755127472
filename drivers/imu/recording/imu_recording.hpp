// An IMU whose samples come from a recording.
#pragma once

#include <array>
#include <cstdint>

#include "imu_ports.hpp"

namespace stator::drivers::imu::recording {

class ImuRecording {
  public:
    // The sample that is current in the recording. The board writes it, then raises data_ready.
    struct Device {
        uint64_t timestamp_sample = 0;   // us
        std::array<float, 3> gyro_B{};   // rad/s
        std::array<float, 3> accel_B{};  // m/s^2, specific force
    };

    explicit ImuRecording(Device& device) : device_(device) {}
    void step(ImuPorts& ports);

  private:
    Device& device_;
};

}  // namespace stator::drivers::imu::recording
