// Philox4x32-10 and the distributions made from its words.
#include "stator/random.hpp"

namespace stator::math {

namespace {

constexpr std::uint32_t low(std::uint64_t x) {
    return static_cast<std::uint32_t>(x);
}
constexpr std::uint32_t high(std::uint64_t x) {
    return static_cast<std::uint32_t>(x >> 32);
}

}  // namespace

std::array<std::uint32_t, 4> philox_4x32_10(std::array<std::uint32_t, 4> counter,
                                            std::array<std::uint32_t, 2> key) {
    constexpr std::uint64_t kMultiplier0 = 0xd2511f53;
    constexpr std::uint64_t kMultiplier1 = 0xcd9e8d57;
    constexpr std::uint32_t kKeyStep0 = 0x9e3779b9;  // golden ratio
    constexpr std::uint32_t kKeyStep1 = 0xbb67ae85;  // sqrt(3) - 1
    auto [c0, c1, c2, c3] = counter;
    auto [k0, k1] = key;
    for (int round = 0; round < 10; ++round) {
        const std::uint64_t product0 = kMultiplier0 * c0;
        const std::uint64_t product1 = kMultiplier1 * c2;
        c0 = high(product1) ^ c1 ^ k0;
        c2 = high(product0) ^ c3 ^ k1;
        c1 = low(product1);
        c3 = low(product0);
        k0 += kKeyStep0;
        k1 += kKeyStep1;
    }
    return {c0, c1, c2, c3};
}

std::uint32_t Random::word() {
    if (words_left_ == 0) {
        block_ = philox_4x32_10({low(next_block_), high(next_block_), low(stream_), high(stream_)},
                                {low(seed_), high(seed_)});
        ++next_block_;
        words_left_ = 4;
    }
    --words_left_;
    return block_[3 - words_left_];
}

double Random::uniform_double() {
    const std::uint64_t first = word() >> 5;
    const std::uint64_t second = word() >> 6;
    return static_cast<double>((first << 26) | second) * 0x1p-53;
}

// sqrt(-2 log u) times the sine of an angle in [-pi/2, pi/2], which has the distribution of a whole
// turn's cosine. It is made from half the angle, which needs no reduction.
float Random::gaussian_float() {
    // In (0, 1], never 0; a float's exponent keeps all 32 bits where they count, near 0.
    const float u = static_cast<float>(word()) * 0x1p-32F + 0x1p-33F;
    const auto phase = static_cast<std::int32_t>(word());
    const SinCos<float> half = sincos(static_cast<float>(phase) * (kPi<float> * 0x1p-33F));
    return sqrt(-2.0F * log(u)) * (2.0F * half.sin * half.cos);
}

double Random::gaussian_double() {
    const double u = uniform_double() + 0x1p-54;
    const auto phase = static_cast<std::int32_t>(word());
    const SinCos<double> half = sincos(static_cast<double>(phase) * (kPi<double> * 0x1p-33));
    return sqrt(-2.0 * log(u)) * (2.0 * half.sin * half.cos);
}

}  // namespace stator::math
