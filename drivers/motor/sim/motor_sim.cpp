// The motors of a simulated board.
#include "motor_sim.hpp"

namespace stator::drivers::motor::sim {

void MotorSim::step(MotorPorts& ports) {
    if (!ports.command || device_.write == nullptr) return;
    device_.write(ports.command->control);
}

}  // namespace stator::drivers::motor::sim
