// The servos of a simulated board.
#include "servo_sim.hpp"

namespace stator::drivers::servo::sim {

void ServoSim::step(ServoPorts& ports) {
    if (!ports.command || device_.write == nullptr) return;
    device_.write(ports.command->control);
}

}  // namespace stator::drivers::servo::sim
