// The folding of CRC-32 by carry-less multiplication, for x86-64 processors that have it: most of a
// block of bytes becomes 16 bytes with the same CRC. Gopal et al., 2009, "Fast CRC Computation for
// Generic Polynomials Using PCLMULQDQ Instruction" (Intel), which also has the constants.
#pragma once

#include <wmmintrin.h>

#include <array>
#include <cstddef>
#include <cstdint>

namespace stator::detail {

inline constexpr size_t kMinFolded = 64;

inline bool can_fold_crc() {
    return __builtin_cpu_supports("pclmul") != 0;
}

// `sum` moved on by as many bits as `constants` are for, plus what stands there.
[[gnu::target("pclmul")]] inline __m128i fold_crc(__m128i sum, __m128i constants, __m128i there) {
    const __m128i low = _mm_clmulepi64_si128(sum, constants, 0x00);
    const __m128i high = _mm_clmulepi64_si128(sum, constants, 0x11);
    return _mm_xor_si128(_mm_xor_si128(low, high), there);
}

// Takes whole steps of 16 bytes off the front of at least kMinFolded bytes. `crc`: of what is
// before them, inverted; that of the result and the bytes left begins at 0, inverted.
[[gnu::target("pclmul")]] inline std::array<uint8_t, 16> fold_crc(uint32_t crc,
                                                                  const uint8_t*& bytes,
                                                                  size_t& count) {
    const auto load = [](const uint8_t* from) {
        return _mm_loadu_si128(reinterpret_cast<const __m128i*>(from));
    };
    const __m128i by_512_bits = _mm_set_epi64x(0x1C6E41596, 0x154442BD4);
    const __m128i by_128_bits = _mm_set_epi64x(0x0CCAA009E, 0x1751997D0);
    // Four sums side by side, as each multiplication waits for the one before.
    __m128i sums[4] = {load(bytes), load(bytes + 16), load(bytes + 32), load(bytes + 48)};
    sums[0] = _mm_xor_si128(sums[0], _mm_cvtsi32_si128(static_cast<int>(crc)));
    for (bytes += 64, count -= 64; count >= 64; bytes += 64, count -= 64) {
        for (size_t i = 0; i < 4; ++i) {
            sums[i] = fold_crc(sums[i], by_512_bits, load(bytes + 16 * i));
        }
    }
    __m128i sum = sums[0];
    for (size_t i = 1; i < 4; ++i) sum = fold_crc(sum, by_128_bits, sums[i]);
    for (; count >= 16; bytes += 16, count -= 16) sum = fold_crc(sum, by_128_bits, load(bytes));
    std::array<uint8_t, 16> folded;
    _mm_storeu_si128(reinterpret_cast<__m128i*>(folded.data()), sum);
    return folded;
}

}  // namespace stator::detail
