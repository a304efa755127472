// Checksums, and the one bit pattern of all NaNs.
#include <gtest/gtest.h>

#include <array>
#include <set>

#include "stator/canonical.hpp"
#include "stator/crc32.hpp"
#include "stator/sample_hash.hpp"

namespace stator {
namespace {

TEST(crc32, has_the_published_check_value) {
    // "CRC-32/ISO-HDLC" in the catalogue of CRC algorithms: 0xCBF43926 for these nine digits.
    EXPECT_EQ(crc32(0, "123456789", 9), 0xCBF43926U);
    EXPECT_EQ(crc32(crc32(0, "1234", 4), "56789", 5), 0xCBF43926U);
    EXPECT_EQ(crc32(0, "", 0), 0U);
    EXPECT_EQ(crc32_bitwise("123456789", 9), 0xCBF43926U);
}

TEST(sample_hash, differs_for_samples_that_differ) {
    // (0 ^ 1) * 0x9E3779B1, exclusive or its upper 17 bits.
    const std::array<uint32_t, 1> one{1};
    EXPECT_EQ(sample_hash(one.data(), 4), 0x9E3779B1U ^ (0x9E3779B1U >> 15));
    std::array<uint32_t, 8> sample{};
    std::set<uint32_t> hashes{sample_hash(sample.data(), sizeof sample)};
    for (uint32_t& word : sample) {
        for (unsigned bit = 0; bit < 32; ++bit) {
            word = 1U << bit;
            EXPECT_TRUE(hashes.insert(sample_hash(sample.data(), sizeof sample)).second);
        }
        word = 0;
    }
}

TEST(canonicalise, changes_nothing_but_the_bits_of_a_nan) {
    constexpr FloatRun kRuns[] = {{0, 3, 4}, {16, 2, 8}};
    struct {
        std::array<uint32_t, 3> singles{0xFFC12345, 0xFF800000, 0x7F800001};
        uint32_t other = 0xFFFFFFFF;
        std::array<uint64_t, 2> doubles{0xFFF0000000000001, 0x7FF0000000000000};
    } sample;
    canonicalise(reinterpret_cast<std::byte*>(&sample), kRuns, 2);
    EXPECT_EQ(sample.singles, (std::array<uint32_t, 3>{0x7FC00000, 0xFF800000, 0x7FC00000}));
    EXPECT_EQ(sample.other, 0xFFFFFFFFU);
    EXPECT_EQ(sample.doubles, (std::array<uint64_t, 2>{0x7FF8000000000000, 0x7FF0000000000000}));
}

}  // namespace
}  // namespace stator
