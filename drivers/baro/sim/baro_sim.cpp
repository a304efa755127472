// The barometer of a simulated board.
#include "baro_sim.hpp"

namespace stator::drivers::baro::sim {

void BaroSim::step(BaroPorts& ports) {
    const auto [sample, count] = device_.get();
    if (count == published_) return;
    published_ = count;
    ports.pressure.publish([&sample = sample] {
        return SensorBaro{.timestamp_sample = sample.timestamp_sample,
                          .pressure = sample.pressure,
                          .temperature = sample.temperature_degc};
    });
}

}  // namespace stator::drivers::baro::sim
