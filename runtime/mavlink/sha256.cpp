// SHA-256 (FIPS 180-4).
#include "stator/mavlink/sha256.hpp"

#include <bit>

namespace stator::mav {

namespace {

// 4.2.2: of the cube roots of the first 64 primes.
constexpr std::array<uint32_t, 64> kRounds{
    0x428A2F98, 0x71374491, 0xB5C0FBCF, 0xE9B5DBA5, 0x3956C25B, 0x59F111F1, 0x923F82A4, 0xAB1C5ED5,
    0xD807AA98, 0x12835B01, 0x243185BE, 0x550C7DC3, 0x72BE5D74, 0x80DEB1FE, 0x9BDC06A7, 0xC19BF174,
    0xE49B69C1, 0xEFBE4786, 0x0FC19DC6, 0x240CA1CC, 0x2DE92C6F, 0x4A7484AA, 0x5CB0A9DC, 0x76F988DA,
    0x983E5152, 0xA831C66D, 0xB00327C8, 0xBF597FC7, 0xC6E00BF3, 0xD5A79147, 0x06CA6351, 0x14292967,
    0x27B70A85, 0x2E1B2138, 0x4D2C6DFC, 0x53380D13, 0x650A7354, 0x766A0ABB, 0x81C2C92E, 0x92722C85,
    0xA2BFE8A1, 0xA81A664B, 0xC24B8B70, 0xC76C51A3, 0xD192E819, 0xD6990624, 0xF40E3585, 0x106AA070,
    0x19A4C116, 0x1E376C08, 0x2748774C, 0x34B0BCB5, 0x391C0CB3, 0x4ED8AA4A, 0x5B9CCA4F, 0x682E6FF3,
    0x748F82EE, 0x78A5636F, 0x84C87814, 0x8CC70208, 0x90BEFFFA, 0xA4506CEB, 0xBEF9A3F7, 0xC67178F2};

// 4.1.2
uint32_t choose(uint32_t x, uint32_t y, uint32_t z) {
    return (x & y) ^ (~x & z);
}
uint32_t majority(uint32_t x, uint32_t y, uint32_t z) {
    return (x & y) ^ (x & z) ^ (y & z);
}
uint32_t turned(uint32_t x, int a, int b, int c) {
    return std::rotr(x, a) ^ std::rotr(x, b) ^ std::rotr(x, c);
}
uint32_t mixed(uint32_t x, int a, int b, int shift) {
    return std::rotr(x, a) ^ std::rotr(x, b) ^ (x >> shift);
}

}  // namespace

// 6.2.2. Of the schedule, only the newest 16 words are kept.
void Sha256::take_block() {
    std::array<uint32_t, 16> schedule{};
    for (std::size_t i = 0; i < kBlock; ++i) {
        schedule[i / 4] = schedule[i / 4] << 8 | block_[i];
    }
    auto [a, b, c, d, e, f, g, h] = state_;
    for (std::size_t i = 0; i < kRounds.size(); ++i) {
        uint32_t& word = schedule[i % 16];
        if (i >= 16) {
            word += mixed(schedule[(i + 14) % 16], 17, 19, 10) + schedule[(i + 9) % 16] +
                    mixed(schedule[(i + 1) % 16], 7, 18, 3);
        }
        const uint32_t first = h + turned(e, 6, 11, 25) + choose(e, f, g) + kRounds[i] + word;
        const uint32_t second = turned(a, 2, 13, 22) + majority(a, b, c);
        h = g;
        g = f;
        f = e;
        e = d + first;
        d = c;
        c = b;
        b = a;
        a = first + second;
    }
    const std::array<uint32_t, 8> added{a, b, c, d, e, f, g, h};
    for (std::size_t i = 0; i < state_.size(); ++i) state_[i] += added[i];
}

void Sha256::add(std::span<const uint8_t> bytes) {
    for (const uint8_t byte : bytes) {
        block_[size_++ % kBlock] = byte;
        if (size_ % kBlock == 0) take_block();
    }
}

// 5.1.1
Sha256::Digest Sha256::finish() {
    const uint32_t size = size_;
    constexpr uint8_t kEnd = 0x80;
    constexpr uint8_t kZero = 0;
    add({&kEnd, 1});
    while (size_ % kBlock != kBlock - sizeof(uint64_t)) add({&kZero, 1});
    const uint64_t bits = uint64_t{size} * 8;
    for (int shift = 56; shift >= 0; shift -= 8) {
        const auto byte = static_cast<uint8_t>(bits >> shift);
        add({&byte, 1});
    }
    Digest digest{};
    for (std::size_t i = 0; i < digest.size(); ++i) {
        digest[i] = static_cast<uint8_t>(state_[i / 4] >> (24 - 8 * (i % 4)));
    }
    return digest;
}

}  // namespace stator::mav
