// A region of the memory protection unit around a memory (DDI 0403E, B3.5.8 and B3.5.9): its size
// is a power of two, and its base a multiple of that. Eighths of it can be switched off.
#pragma once

#include <bit>
#include <cstdint>

namespace stator {

struct GuardRegion {
    uint32_t base;
    uint32_t size_bits;    // it has 2^size_bits bytes
    uint32_t off_eighths;  // bit i: the access of eighth i is that without the region

    constexpr uint32_t eighth_bytes() const { return 1U << (size_bits - kEighthBits); }
    // The fields of the attribute register.
    constexpr uint32_t size_fields() const { return off_eighths << 8 | (size_bits - 1) << 1; }

    static constexpr uint32_t kEighthBits = 3;
};

// The smallest region that covers `bytes` from `at` on. What it covers besides is less than an
// eighth of it on each side, as of a flash whose first sectors hold a bootloader. At least 256
// bytes, below which there are no eighths, and at most 2 GB.
constexpr GuardRegion region_around(uint32_t at, uint32_t bytes) {
    const uint32_t last = at + (bytes - 1);
    uint32_t size_bits = 8;
    while (at >> size_bits != last >> size_bits) ++size_bits;
    GuardRegion region{at >> size_bits << size_bits, size_bits, 0};
    for (uint32_t i = 0; i < 8; ++i) {
        const uint32_t begin = region.base + i * region.eighth_bytes();
        const bool is_outside = begin > last || begin + (region.eighth_bytes() - 1) < at;
        if (is_outside) region.off_eighths |= 1U << i;
    }
    return region;
}

// A flash behind a bootloader of 16 KB: all of the flash, as its first eighth holds both.
static_assert(region_around(0x08004000, 2080768).base == 0x08000000);
static_assert(region_around(0x08004000, 2080768).size_fields() == 20U << 1);

}  // namespace stator
