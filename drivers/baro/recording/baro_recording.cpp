// A barometer whose samples come from a recording.
#include "baro_recording.hpp"

namespace stator::drivers::baro::recording {

void BaroRecording::step(BaroPorts& ports) {
    if (device_.samples == published_) return;
    const Device sample = device_;
    published_ = sample.samples;
    ports.pressure.publish([&] {
        return SensorBaro{.timestamp_sample = sample.timestamp_sample,
                          .pressure = sample.pressure,
                          .temperature = 15.0F};
    });
}

}  // namespace stator::drivers::baro::recording
