// The motion capture of a simulated board.
#include "mocap_sim.hpp"

#include "stator/scalar.hpp"

namespace stator::drivers::mocap::sim {

void MocapSim::step(MocapPorts& ports) {
    if (!ports.fired.received) return;
    const Device seen = device_;
    const math::SinCos<float> half = math::sincos(0.5F * seen.yaw);
    ports.odometry.publish([&] {
        return VehicleOdometry{.timestamp_sample = seen.timestamp_sample,
                               .position = seen.position_N,
                               .q = {half.cos, 0.0F, 0.0F, half.sin}};
    });
}

}  // namespace stator::drivers::mocap::sim
