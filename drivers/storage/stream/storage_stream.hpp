// Storage at the other end of a line: hands log blocks to the board as they come; they cannot be
// read again.
#pragma once

#include <cstddef>
#include <cstdint>

#include "storage_ports.hpp"

namespace stator::drivers::storage::stream {

class StorageStream {
  public:
    // The board puts its function here, which says whether it stored all; without one, blocks are
    // dropped, as with no card in the slot.
    struct Device {
        uint32_t errors = 0;  // blocks that were not stored; a debugger finds it at the begin
        bool (*append)(const uint8_t* bytes, size_t count) = nullptr;
    };

    explicit StorageStream(Device& device) : device_(device) {}
    void step(StoragePorts& ports);

  private:
    void append(const LogBlock& block);

    Device& device_;
};

}  // namespace stator::drivers::storage::stream
