// The checksum of all parameters.
#include "stator/parameter_hash.hpp"

#include <gtest/gtest.h>

#include <bit>

namespace stator {
namespace {

ParameterBits bits(float value) {
    return std::bit_cast<ParameterBits>(value);
}

// The check value of CRC-32 without inversions; bit by bit: sum(bytes x^n) mod the polynomial.
TEST(ParameterHash, the_checksum_has_its_check_value) {
    EXPECT_EQ(plain_crc32(0, "123456789", 9), 0x2DFD2D88U);
    EXPECT_EQ(plain_crc32(plain_crc32(0, "1234", 4), "56789", 5), 0x2DFD2D88U);
}

// As pymavlink and PX4 compute it for these three: an int32, a float, an int32.
TEST(ParameterHash, is_that_of_ground_stations) {
    uint32_t hash = hash_parameter(0, "MAV_SYS_ID", 1);
    hash = hash_parameter(hash, "MIS_TAKEOFF_ALT", bits(2.5F));
    EXPECT_EQ(hash_parameter(hash, "NAV_RCL_ACT", 2), 0x00C057C3U);
}

}  // namespace
}  // namespace stator
