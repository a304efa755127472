// The magnetometer of a simulated board.
#include "mag_sim.hpp"

namespace stator::drivers::mag::sim {

void MagSim::step(MagPorts& ports) {
    if (!ports.fired.data_ready) return;
    const Device sample = device_;
    ports.mag.publish([&] {
        return SensorMag{.timestamp_sample = sample.timestamp_sample, .xyz = sample.field_B_gauss};
    });
}

}  // namespace stator::drivers::mag::sim
