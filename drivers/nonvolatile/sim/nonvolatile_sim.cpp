// The nonvolatile memory of a simulated board.
#include "nonvolatile_sim.hpp"

namespace stator::drivers::nonvolatile::sim {

bool NonvolatileSim::Port::read(uint32_t address, std::span<uint8_t> bytes) const {
    return device.read != nullptr && device.read(address, bytes);
}

bool NonvolatileSim::Port::write(uint32_t address, std::span<const uint8_t> bytes) const {
    return device.write != nullptr && device.write(address, bytes);
}

}  // namespace stator::drivers::nonvolatile::sim
