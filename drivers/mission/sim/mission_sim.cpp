// The mission of a simulated board.
#include "mission_sim.hpp"

namespace stator::drivers::mission::sim {

void MissionSim::step(MissionPorts& ports) {
    if (device_.version == published_) return;
    published_ = device_.version;
    ports.mission.publish([&] { return device_.mission; });
}

}  // namespace stator::drivers::mission::sim
