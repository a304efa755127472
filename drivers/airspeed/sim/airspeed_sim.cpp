// The pitot tube of a simulated board.
#include "airspeed_sim.hpp"

namespace stator::drivers::airspeed::sim {

void AirspeedSim::step(AirspeedPorts& ports) {
    const auto [sample, count] = device_.get();
    if (count == published_) return;
    published_ = count;
    ports.pressure.publish([&sample = sample] {
        return DifferentialPressure{.timestamp_sample = sample.timestamp_sample,
                                    .differential_pressure_pa = sample.pressure,
                                    .temperature = sample.temperature_degc};
    });
}

}  // namespace stator::drivers::airspeed::sim
