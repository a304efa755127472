// Checksum and file of all parameters, against a reader that was written from the format alone.
#include "stator/parameter_pack.hpp"

#include <gtest/gtest.h>

#include <bit>
#include <string>
#include <vector>

#include "stator/parameter_hash.hpp"

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

struct Known {
    std::string id;
    int type;
    ParameterBits value;
    ParameterBits standard;
    bool operator==(const Known&) const = default;
};

// A reader as ground stations have it; fails for a value that lies in two blocks.
std::vector<Known> read(const std::vector<uint8_t>& file, uint32_t block_bytes) {
    std::vector<Known> found;
    std::string before;
    size_t at = 6;
    const auto number = [&](unsigned count) {
        uint32_t value = 0;
        for (unsigned i = 0; i < count; ++i) value |= uint32_t{file.at(at++)} << 8 * i;
        return value;
    };
    while (at < file.size()) {
        if (file[at] == 0) {
            ++at;
            continue;
        }
        const uint32_t head = number(2);
        const unsigned shared = head >> 8 & 15U;
        const unsigned more = (head >> 12) + 1;
        before = before.substr(0, shared);
        for (unsigned i = 0; i < more; ++i) before += static_cast<char>(number(1));
        EXPECT_LE(at % block_bytes + 4, block_bytes) << before << " lies in two blocks";
        const uint32_t value = number(4);
        const uint32_t standard = (head & 0x10U) != 0 ? number(4) : value;
        found.push_back({before, static_cast<int>(head & 15U), value, standard});
    }
    return found;
}

const std::vector<Known> kAll{
    {"A", 3, 1, 1},
    {"MPC_XY_CRUISE", 4, bits(5.0F), bits(5.0F)},
    {"MPC_XY_VEL_MAX", 4, bits(12.0F), bits(10.0F)},
    {"MPC_XY_VEL_MAX_A", 3, 0xFFFFFFFFU, 7},
    {"SIXTEEN_LETTERS1", 4, bits(0.0F), bits(0.0F)},
    {"SIXTEEN_LETTERS2", 4, bits(-1.5F), bits(0.0F)},
    {"ZZZ", 3, 0, 3},
};

std::vector<uint8_t> write(uint32_t block_bytes, bool with_defaults) {
    std::vector<uint8_t> file(parameter_pack::kHeadBytes);
    const auto count = static_cast<uint16_t>(kAll.size());
    EXPECT_EQ(parameter_pack::put_head(file, count, count, with_defaults), 6U);
    std::string_view before;
    for (const Known& known : kAll) {
        uint8_t bytes[parameter_pack::kMaxEntryBytes];
        const parameter_pack::Entry entry{
            .before = before,
            .id = known.id,
            .type = known.type == 4 ? ParameterType::kFloat : ParameterType::kInt32,
            .value = known.value,
            .standard = known.standard};
        const auto place = static_cast<uint32_t>(file.size());
        const unsigned length =
            parameter_pack::put_entry(bytes, place, block_bytes, entry, with_defaults);
        EXPECT_GT(length, 0U);
        EXPECT_EQ(parameter_pack::put_entry(std::span(bytes).first(length - 1), place, block_bytes,
                                            entry, with_defaults),
                  0U)
            << "never over the end";
        file.insert(file.end(), bytes, bytes + length);
        before = known.id;
    }
    return file;
}

TEST(ParameterPack, is_read_as_it_was_written_in_blocks_of_every_size) {
    for (uint32_t block_bytes = 5; block_bytes < 250; ++block_bytes) {
        EXPECT_EQ(read(write(block_bytes, true), block_bytes), kAll) << block_bytes;
    }
}

TEST(ParameterPack, without_defaults_they_are_left_out) {
    std::vector<Known> expected = kAll;
    for (Known& known : expected) known.standard = known.value;
    EXPECT_EQ(read(write(80, false), 80), expected);
}

TEST(ParameterPack, begins_with_magic_and_counts) {
    const std::vector<uint8_t> with = write(80, true);
    const std::vector<uint8_t> without = write(80, false);
    EXPECT_EQ(std::vector(with.begin(), with.begin() + 6),
              (std::vector<uint8_t>{0x1C, 0x67, 7, 0, 7, 0}));
    EXPECT_EQ(without[0], 0x1B);
    // "A", then of MPC_XY_CRUISE nothing shared.
    EXPECT_EQ(std::vector(without.begin() + 6, without.begin() + 15),
              (std::vector<uint8_t>{3, 0x00, 'A', 1, 0, 0, 0, 4, 12 << 4}));
}

TEST(ParameterPack, a_head_needs_its_room) {
    uint8_t bytes[5];
    EXPECT_EQ(parameter_pack::put_head(bytes, 1, 1, false), 0U);
}

}  // namespace
}  // namespace stator
