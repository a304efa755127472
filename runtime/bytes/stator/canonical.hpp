// One bit pattern for all NaNs: their sign and payload differ between machines, so that they are
// made canonical where a sample is logged, recorded or compared. No node can tell, as none reads
// them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>

namespace stator {

// Consecutive numbers of one sample that may be NaN.
struct FloatRun {
    uint16_t offset;
    uint16_t count;
    uint8_t bytes;  // 4 or 8
};

namespace detail {

// `exponent` has the bits that are all ones in infinities and NaNs.
template <class Bits>
void canonicalise(std::byte* numbers, size_t count, Bits exponent, Bits canonical) {
    for (const std::byte* end = numbers + count * sizeof(Bits); numbers != end;) {
        Bits bits = 0;
        std::memcpy(&bits, numbers, sizeof bits);
        numbers += sizeof bits;
        if (static_cast<Bits>(bits << 1) > static_cast<Bits>(exponent << 1)) [[unlikely]] {
            std::memcpy(numbers - sizeof bits, &canonical, sizeof canonical);
        }
    }
}

}  // namespace detail

inline void canonicalise(std::byte* sample, const FloatRun* runs, size_t count) {
    for (const FloatRun* run = runs; run != runs + count; ++run) {
        std::byte* numbers = sample + run->offset;
        if (run->bytes == sizeof(uint32_t)) {
            detail::canonicalise<uint32_t>(numbers, run->count, 0x7F800000, 0x7FC00000);
        } else {
            detail::canonicalise<uint64_t>(numbers, run->count, 0x7FF0000000000000,
                                           0x7FF8000000000000);
        }
    }
}

}  // namespace stator
