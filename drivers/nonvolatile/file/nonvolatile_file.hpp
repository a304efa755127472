// A file of a host in place of a nonvolatile memory.
#pragma once

#include "../nonvolatile_driver.hpp"

namespace stator::drivers::nonvolatile::file {

// A write returns when the medium has it, since the board opens the file with O_DSYNC: where that
// takes long, it holds up the node's level.
class NonvolatileFile {
  public:
    struct Device {
        int file = -1;  // the board opens it, for reading and writing, and closes it
        mav::SharedKey* key = nullptr;  // of the lines; null: nobody asks for it
        // For the board, while the graph stands still: what the node has published.
        NonvolatileStatus status{};
    };
    struct Port {
        bool read(uint32_t address, std::span<uint8_t> bytes) const;
        bool write(uint32_t address, std::span<const uint8_t> bytes) const;
        Device& device;
    };
    // The file begins with a head, and with it is so long. The two halves of the memory share no
    // sector with each other, nor with the head.
    static constexpr uint32_t kHeadBytes = 4096;
    static constexpr uint32_t kFileBytes = kHeadBytes + RecordStore<Port>::kBytes;

    explicit NonvolatileFile(Device& device) : device_(device), driver_(Port{device}) {}
    void step(NonvolatilePorts& ports);

  private:
    Device& device_;
    NonvolatileDriver<Port> driver_;
};

}  // namespace stator::drivers::nonvolatile::file
