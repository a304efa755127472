// A magnetometer whose samples come from a recording.
#include "mag_recording.hpp"

namespace stator {

void MagRecording::step(MagPorts& ports) {
    if (!ports.fired.data_ready) return;
    constexpr float kGaussPerMicrotesla = 0.01f;
    const Device sample = device_;
    ports.mag.publish([&] {
        const auto& field = sample.field_B_ut;
        return SensorMag{.timestamp_sample = sample.timestamp_sample,
                         .xyz = {kGaussPerMicrotesla * field[0], kGaussPerMicrotesla * field[1],
                                 kGaussPerMicrotesla * field[2]}};
    });
}

}  // namespace stator
