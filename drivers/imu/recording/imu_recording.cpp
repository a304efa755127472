// An IMU whose samples come from a recording.
#include "imu_recording.hpp"

namespace stator::drivers::imu::recording {

void ImuRecording::step(ImuPorts& ports) {
    if (!ports.fired.data_ready) return;
    const Device sample = device_;
    ports.accel.publish([&] {
        return SensorAccel{.timestamp_sample = sample.timestamp_sample, .xyz = sample.accel_B};
    });
    ports.gyro.publish([&] {
        return SensorGyro{.timestamp_sample = sample.timestamp_sample, .xyz = sample.gyro_B};
    });
}

}  // namespace stator::drivers::imu::recording
