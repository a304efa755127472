// ATT_POS_MOCAP from a line. The frame comes from pymavlink 2.4.50:
//   mav = common.MAVLink(None, srcSystem=1, srcComponent=197)
//   common.MAVLink_att_pos_mocap_message(1234567, [0.8, 0, 0, 0.6], 1.5, -2.25, -3).pack(mav)
// Of its 84 bytes more, all zeros, MAVLink 2 sends none.
#include "mocap_mavlink.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "stator/testing.hpp"

namespace stator::drivers::mocap::mavlink {
namespace {

const std::vector<uint8_t> kFrame{
    0xFD, 0x24, 0x00, 0x00, 0x00, 0x01, 0xC5, 0x8A, 0x00, 0x00, 0x87, 0xD6, 0x12, 0x00, 0x00, 0x00,
    0x00, 0x00, 0xCD, 0xCC, 0x4C, 0x3F, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x9A, 0x99,
    0x19, 0x3F, 0x00, 0x00, 0xC0, 0x3F, 0x00, 0x00, 0x10, 0xC0, 0x00, 0x00, 0x40, 0xC0, 0xE2, 0x76};
constexpr uint64_t kNow_us = 2'000'000;
constexpr uint32_t kDelay_us = 5'500;

// What waits on the line. The driver asks through a function, as the board's line has it.
std::vector<uint8_t> waiting;
size_t read_line(std::span<uint8_t> bytes) {
    const size_t count = std::min(bytes.size(), waiting.size());
    std::copy_n(waiting.begin(), count, bytes.begin());
    waiting.erase(waiting.begin(), waiting.begin() + static_cast<ptrdiff_t>(count));
    return count;
}

class Mocap : public ::testing::Test {
  public:
    Mocap() { waiting.clear(); }
    std::optional<VehicleOdometry> hear(const std::vector<uint8_t>& bytes) {
        waiting.insert(waiting.end(), bytes.begin(), bytes.end());
        MocapPorts ports{.now = kNow_us};
        stator::testing::Probe published(ports.odometry, ports.now);
        driver_.step(ports);
        if (published.count() == 0) return {};
        return published.newest();
    }
    MocapMavlink::Device device{.read = read_line, .delay_us = kDelay_us};

  private:
    MocapMavlink driver_{device};
};

std::vector<uint8_t> joined(std::vector<uint8_t> first, const std::vector<uint8_t>& second) {
    first.insert(first.end(), second.begin(), second.end());
    return first;
}

TEST_F(Mocap, a_pose_is_published_with_the_time_of_its_picture) {
    const auto pose = hear(kFrame);
    ASSERT_TRUE(pose);
    EXPECT_EQ(pose->timestamp_sample, kNow_us - kDelay_us);
    EXPECT_EQ(pose->position, (std::array{1.5F, -2.25F, -3.0F}));
    EXPECT_EQ(pose->q, (std::array{0.8F, 0.0F, 0.0F, 0.6F}));
    EXPECT_EQ(device.damaged, 0U);
}

TEST_F(Mocap, a_frame_may_come_in_pieces) {
    const std::vector<uint8_t> first(kFrame.begin(), kFrame.begin() + 20);
    const std::vector<uint8_t> second(kFrame.begin() + 20, kFrame.end());
    EXPECT_FALSE(hear(first));
    EXPECT_TRUE(hear(second));
}

TEST_F(Mocap, two_frames_at_once_are_one_pose) {
    EXPECT_TRUE(hear(joined(kFrame, kFrame)));
    EXPECT_FALSE(hear({}));
    EXPECT_EQ(device.damaged, 0U);
}

TEST_F(Mocap, each_flipped_bit_behind_the_begin_is_refused) {
    for (size_t bit = 8 * 10; bit < 8 * kFrame.size(); ++bit) {
        auto damaged = kFrame;
        damaged[bit / 8] = static_cast<uint8_t>(damaged[bit / 8] ^ 1U << bit % 8);
        EXPECT_FALSE(hear(damaged)) << bit;
    }
    EXPECT_EQ(device.damaged, 8 * (kFrame.size() - 10));
    EXPECT_TRUE(hear(kFrame));
}

TEST_F(Mocap, noise_before_a_frame_is_skipped) {
    EXPECT_TRUE(hear(joined({0x00, 0x55, 0xFE, 0x01}, kFrame)));
}

TEST_F(Mocap, other_messages_are_skipped) {
    auto other = kFrame;
    other[7] = 137;
    EXPECT_FALSE(hear(other));
    EXPECT_EQ(device.damaged, 0U);
    EXPECT_TRUE(hear(kFrame));
}

// A length that is wrong takes bytes of what follows, at most 255; then it goes on.
TEST_F(Mocap, a_wrong_length_costs_a_few_frames_only) {
    auto longest = kFrame;
    longest[1] = 255;
    EXPECT_FALSE(hear(longest));
    unsigned heard = 0;
    for (int i = 0; i < 10; ++i) heard += hear(kFrame) ? 1 : 0;
    EXPECT_GE(heard, 4U);
}

TEST_F(Mocap, without_a_line_nothing_happens) {
    device.read = nullptr;
    EXPECT_FALSE(hear(kFrame));
}

}  // namespace
}  // namespace stator::drivers::mocap::mavlink
