// Storage of a host: appends log blocks to a file that the board opened, and reads it again.
#pragma once

#include <cstdint>
#include <cstdio>

#include "storage_ports.hpp"

namespace stator::drivers::storage::file {

// The log of this run is the only one.
class StorageFile {
  public:
    // Without a file, blocks are dropped, as with no card in the slot. The board opens and closes.
    struct Device {
        std::FILE* file = nullptr;
        std::FILE* reader = nullptr;  // of the same file; null: it cannot be read during the run
        uint64_t bytes_written = 0;
        uint64_t errors = 0;  // blocks that were not written whole
        int reason = 0;       // errno of the first of them

        // From now on the log can be read during the run, if the file is one: a pipe is not.
        void offer(const char* path);
    };

    explicit StorageFile(Device& device) : device_(device) {}
    void step(StoragePorts& ports);

  private:
    void append(const LogBlock& block);
    FilePiece answer(const FileRequest& request);

    Device& device_;
};

}  // namespace stator::drivers::storage::file
