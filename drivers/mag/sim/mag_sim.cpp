// The magnetometer of a simulated board.
#include "mag_sim.hpp"

#include "../mag_calibration.hpp"

namespace stator::drivers::mag::sim {

void MagSim::step(MagPorts& ports) {
    if (!ports.fired.data_ready) return;
    Device sample = device_;
    if (ports.calibration)
        sample.field_B_gauss = calibrated(*ports.calibration, sample.field_B_gauss);
    ports.mag.publish([&] {
        return SensorMag{.timestamp_sample = sample.timestamp_sample, .xyz = sample.field_B_gauss};
    });
}

}  // namespace stator::drivers::mag::sim
