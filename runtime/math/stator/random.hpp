// Random numbers for simulated noise: the same sequence on every machine, one independent stream
// for each sensor.
//
// The generator is Philox4x32-10 (Salmon, Moraes, Dror, Shaw: Parallel random numbers: as easy as
// 1, 2, 3; SC 2011): ten rounds of a keyed bijection of a 128-bit counter. The key is the seed; the
// upper half of the counter is the stream, the lower half the block. So streams of one seed never
// overlap, each is 2^66 words long, and no word depends on how often another stream was asked.
#pragma once

#include <array>
#include <cstdint>

#include "stator/scalar.hpp"

namespace stator::math {

// The bijection itself: four words from a counter and a key, least significant word first.
std::array<std::uint32_t, 4> philox_4x32_10(std::array<std::uint32_t, 4> counter,
                                            std::array<std::uint32_t, 2> key);

// A copy continues where its original stands. Not for secrets.
class Random {
  public:
    explicit Random(std::uint64_t seed, std::uint64_t stream = 0) : seed_(seed), stream_(stream) {}

    // The beginning of another stream of the same seed, wherever this one stands.
    Random split(std::uint64_t stream) const { return Random(seed_, stream); }

    // 32 uniform bits; a block gives four times.
    std::uint32_t word();

    // In [0, 1): float is 24 bits of one word, double is 53 bits of two.
    float uniform_float() { return static_cast<float>(word() >> 8) * 0x1p-24F; }
    double uniform_double();

    // Standard normal (Box and Muller 1958, one of the two); always two words for float, three for
    // double. Never beyond 6.8 (float) or 8.7 (double), where chance gets once in 10^11 or 10^17.
    float gaussian_float();
    double gaussian_double();

  private:
    std::uint64_t seed_;
    std::uint64_t stream_;
    std::uint64_t next_block_ = 0;
    std::array<std::uint32_t, 4> block_{};
    std::uint32_t words_left_ = 0;
};

}  // namespace stator::math
