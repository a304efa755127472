// The chip's RAM as memory of this process at the same address, for drivers that give pointers to
// DMA.
#pragma once

#include <sys/mman.h>

#include <algorithm>
#include <cstdint>
#include <span>

#include "chip/memory.hpp"

namespace stator::chip {

class MappedRam : public Memory {
  public:
    static constexpr uintptr_t kAt = 0x20000000;
    static uint8_t* bytes() {
        static void* const mapped = mmap(reinterpret_cast<void*>(kAt), 4096, PROT_READ | PROT_WRITE,
                                         MAP_PRIVATE | MAP_ANONYMOUS | MAP_FIXED_NOREPLACE, -1, 0);
        return static_cast<uint8_t*>(mapped);
    }
    void fetch(uint32_t address, std::span<uint8_t> to) override {
        std::copy_n(bytes() + (address - kAt), to.size(), to.begin());
    }
    void store(uint32_t address, std::span<const uint8_t> from) override {
        std::ranges::copy(from, bytes() + (address - kAt));
    }
};

}  // namespace stator::chip
