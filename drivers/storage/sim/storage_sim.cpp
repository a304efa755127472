// Storage of a simulated board.
#include "storage_sim.hpp"

#include <algorithm>

namespace stator::drivers::storage::sim {

void StorageSim::step(StoragePorts& ports) {
    if (!ports.block || device_.append == nullptr) return;
    const LogBlock& block = *ports.block;
    const size_t length = std::min<size_t>(block.length, block.data.size());
    if (!device_.append(block.data.data(), length)) ++device_.errors;
}

}  // namespace stator::drivers::storage::sim
