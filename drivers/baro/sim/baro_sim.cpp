// The barometer of a simulated board.
#include "baro_sim.hpp"

namespace stator::drivers::baro::sim {

void BaroSim::step(BaroPorts& ports) {
    if (device_.refresh != nullptr) device_.refresh(device_);
    const Device sample = device_;
    if (sample.samples == published_) return;
    published_ = sample.samples;
    ports.pressure.publish([&] {
        return SensorBaro{.timestamp_sample = sample.timestamp_sample,
                          .pressure = sample.pressure,
                          .temperature = sample.temperature_degc};
    });
}

}  // namespace stator::drivers::baro::sim
