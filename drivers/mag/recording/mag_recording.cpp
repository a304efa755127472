// A magnetometer whose samples come from a recording.
#include "mag_recording.hpp"

namespace stator::drivers::mag::recording {

void MagRecording::step(MagPorts& ports) {
    if (!ports.fired.data_ready) return;
    const Device sample = device_;
    ports.mag.publish([&] {
        return SensorMag{.timestamp_sample = sample.timestamp_sample, .xyz = sample.field_B};
    });
}

}  // namespace stator::drivers::mag::recording
