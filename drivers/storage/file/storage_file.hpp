// Storage of a host: appends log blocks to a file that the board opened.
#pragma once

#include <cstdint>
#include <cstdio>

#include "storage_ports.hpp"

namespace stator::drivers::storage::file {

class StorageFile {
  public:
    // Without a file, blocks are dropped, as with no card in the slot. The board opens and closes.
    struct Device {
        std::FILE* file = nullptr;
        uint64_t bytes_written = 0;
        uint64_t errors = 0;  // blocks that were not written whole
        int reason = 0;       // errno of the first of them
    };

    explicit StorageFile(Device& device) : device_(device) {}
    void step(StoragePorts& ports);

  private:
    Device& device_;
};

}  // namespace stator::drivers::storage::file
