// Regions of the memory protection unit around the memories that chips have.
#include "stator/guard_region.hpp"

#include <gtest/gtest.h>

namespace stator {
namespace {

constexpr uint32_t kKilobyte = 1024;
constexpr uint32_t kFlash = 0x08000000;

bool is_covered(const GuardRegion& region, uint32_t address) {
    if (address < region.base) return false;
    const uint32_t eighth = (address - region.base) / region.eighth_bytes();
    return eighth < 8 && (region.off_eighths >> eighth & 1U) == 0;
}

void expect_legal(uint32_t at, uint32_t bytes) {
    SCOPED_TRACE(testing::Message() << std::hex << at << ", " << bytes << " bytes");
    const GuardRegion region = region_around(at, bytes);
    const uint32_t size = 1U << region.size_bits;
    EXPECT_EQ(region.base % size, 0U);
    EXPECT_GE(size, bytes);
    EXPECT_TRUE(is_covered(region, at));
    EXPECT_TRUE(is_covered(region, at + bytes / 2));
    EXPECT_TRUE(is_covered(region, at + bytes - 1));
    EXPECT_FALSE(is_covered(region, at - region.eighth_bytes()));
    EXPECT_FALSE(is_covered(region, at + (bytes - 1) + region.eighth_bytes()));
}

// From any sector on, to the end of a flash of any size.
TEST(GuardRegion, is_legal_for_every_flash_behind_every_bootloader) {
    for (const uint32_t flash : {256U, 512U, 768U, 1024U, 1536U, 2048U}) {
        for (uint32_t loader = 0; loader < flash; loader += 16) {
            expect_legal(kFlash + loader * kKilobyte, (flash - loader) * kKilobyte);
        }
    }
}

// The attribute register's SIZE is one less than the power of two (B3.5.9).
TEST(GuardRegion, of_a_whole_flash_is_that_flash) {
    const GuardRegion region = region_around(kFlash, 1024 * kKilobyte);
    EXPECT_EQ(region.base, kFlash);
    EXPECT_EQ(region.size_fields(), 19U << 1);
}

TEST(GuardRegion, leaves_out_the_eighths_that_hold_nothing_of_the_memory) {
    const GuardRegion region = region_around(kFlash + 512 * kKilobyte, 768 * kKilobyte);
    EXPECT_EQ(region.base, kFlash);
    EXPECT_EQ(region.size_fields(), 0b11100011U << 8 | 20U << 1);
}

TEST(GuardRegion, of_half_a_gigabyte) {
    EXPECT_EQ(region_around(0x20000000, 0x20000000).size_fields(), 28U << 1);
    EXPECT_EQ(region_around(0x20000000, 0x20000000).base, 0x20000000U);
}

}  // namespace
}  // namespace stator
