// A magnetometer whose samples come from a recording.
#include "mag_recording.hpp"

#include "../mag_calibration.hpp"

namespace stator::drivers::mag::recording {

void MagRecording::step(MagPorts& ports) {
    if (!ports.fired.data_ready) return;
    Device sample = device_;
    if (ports.calibration) sample.field_B = calibrated(*ports.calibration, sample.field_B);
    ports.mag.publish([&] {
        return SensorMag{.timestamp_sample = sample.timestamp_sample, .xyz = sample.field_B};
    });
}

}  // namespace stator::drivers::mag::recording
