// An IMU whose samples come from a recording.
#include "imu_recording.hpp"

#include "../imu_calibration.hpp"

namespace stator::drivers::imu::recording {

void ImuRecording::step(ImuPorts& ports) {
    if (!ports.fired.data_ready) return;
    Device sample = device_;
    if (ports.calibration) {
        sample.gyro_B = calibrated_gyro(*ports.calibration, sample.gyro_B);
        sample.accel_B = calibrated_accel(*ports.calibration, sample.accel_B);
    }
    ports.accel.publish([&] {
        return SensorAccel{.timestamp_sample = sample.timestamp_sample, .xyz = sample.accel_B};
    });
    ports.gyro.publish([&] {
        return SensorGyro{.timestamp_sample = sample.timestamp_sample, .xyz = sample.gyro_B};
    });
}

}  // namespace stator::drivers::imu::recording
