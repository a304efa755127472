// The mission of a simulated board.
#include "mission_sim.hpp"

namespace stator::drivers::mission::sim {

bool MissionSim::Port::read(uint32_t address, std::span<uint8_t> bytes) const {
    return device.read != nullptr && device.read(address, bytes);
}

bool MissionSim::Port::write(uint32_t address, std::span<const uint8_t> bytes) const {
    return device.write != nullptr && device.write(address, bytes);
}

}  // namespace stator::drivers::mission::sim
