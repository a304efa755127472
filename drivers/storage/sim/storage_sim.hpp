// Storage of a simulated board: hands log blocks to the board as they come, which cannot be read
// again.
#pragma once

#include <cstddef>
#include <cstdint>

#include "storage_ports.hpp"

namespace stator::drivers::storage::sim {

class StorageSim {
  public:
    // The board puts its function here, which says whether it stored all; without one, blocks are
    // dropped, as with no card in the slot.
    struct Device {
        bool (*append)(const uint8_t* bytes, size_t count) = nullptr;
        uint32_t errors = 0;  // blocks that were not stored
    };

    explicit StorageSim(Device& device) : device_(device) {}
    void step(StoragePorts& ports);

  private:
    void append(const LogBlock& block);

    Device& device_;
};

}  // namespace stator::drivers::storage::sim
