// The memory of the machine, as the chip's DMA reaches it.
#pragma once

#include <cstdint>
#include <span>

namespace stator::chip {

class Memory {
  public:
    Memory() = default;
    virtual ~Memory() = default;
    Memory(const Memory&) = delete;
    Memory& operator=(const Memory&) = delete;

    virtual void fetch(uint32_t address, std::span<uint8_t> bytes) = 0;
    virtual void store(uint32_t address, std::span<const uint8_t> bytes) = 0;
};

}  // namespace stator::chip
