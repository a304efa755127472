// The motors of a simulated board.
#include "motor_sim.hpp"

#include "stator/scalar.hpp"

namespace stator::drivers::motor::sim {

void MotorSim::step(MotorPorts& ports) {
    if (ports.command) commanded_us_ = ports.now;
    const bool is_silent = commanded_us_ != 0 && ports.now > commanded_us_ + kSilent_us;
    if (device_.write == nullptr || (!ports.command && !is_silent)) return;
    Control stopped;
    stopped.fill(math::canonical_nan<float>());
    device_.write(ports.command ? ports.command->control : stopped);
}

}  // namespace stator::drivers::motor::sim
