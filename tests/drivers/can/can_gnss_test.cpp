// The node for a satellite receiver on a CAN bus, called with frames.
#include "can_gnss.hpp"

#include <gtest/gtest.h>

#include <array>
#include <vector>

#include "frames.hpp"
#include "stator/math/bits.hpp"
#include "stator/testing.hpp"

namespace stator::apps::can_gnss {
namespace {

using dronecan::equipment::gnss::Auxiliary;
using dronecan::equipment::gnss::Fix2;

constexpr float kUnknown = math::canonical_nan<float>();

struct Gnss : ::testing::Test {
    uint32_t feed(const std::vector<CanFrame>& frames) {
        uint32_t count = 0;
        for (const CanFrame& frame : frames) {
            CanGnssPorts ports{
                .now = frame.timestamp, .can = Input(frame), .params = Input(params, is_first)};
            is_first = false;
            stator::testing::Probe position(ports.position, ports.now);
            node.step(ports);
            count += position.count();
            if (position.count() != 0) newest = position.newest();
        }
        return count;
    }
    static Fix2 fix() {
        return {.longitude_deg_1e8 = 854'559'400,
                .latitude_deg_1e8 = 4'739'774'200,
                .height_msl_mm = 488'000,
                .ned_velocity = {1.0F, 2.0F, 3.0F},
                .sats_used = 9,
                .status = Fix2::kStatus3dFix};
    }

    CanGnss node;
    CanGnssParams params{.first_node = 40, .last_node = 49, .latency = 0.1F, .range_error = 2.0F};
    bool is_first = true;
    SensorGps newest{};
};

TEST_F(Gnss, a_fix_becomes_a_position) {
    Fix2 message = fix();
    message.covariance.assign(std::array{4.0F, 4.0F, 9.0F, 0.25F, 0.25F, 0.25F});
    ASSERT_EQ(feed(frames_of(message, 40, 1'000'000)), 1U);
    EXPECT_EQ(newest.timestamp_sample, 900'000U);
    EXPECT_EQ(newest.latitude_deg, 47.397742);
    EXPECT_EQ(newest.longitude_deg, 8.545594);
    EXPECT_EQ(newest.altitude_msl_m, 488.0);
    EXPECT_EQ(newest.eph, 2.0F);
    EXPECT_EQ(newest.epv, 3.0F);
    EXPECT_EQ(newest.fix_type, SensorGps::FixType::kFix3d);
    EXPECT_EQ(newest.satellites_used, 9);
}

TEST_F(Gnss, without_covariance_the_geometry_tells_the_error) {
    feed(frames_of(Auxiliary{.hdop = 0.75F, .vdop = 1.5F}, 40, 1'000'000));
    ASSERT_EQ(feed(frames_of(fix(), 40, 1'000'000)), 1U);
    EXPECT_EQ(newest.eph, 1.5F);
    EXPECT_EQ(newest.epv, 3.0F);
    EXPECT_TRUE(math::is_nan(newest.s_variance_m_s));
}

TEST_F(Gnss, a_geometry_that_comes_in_the_middle_of_a_fix_counts_for_it) {
    std::vector<CanFrame> frames = frames_of(fix(), 40, 1'000'000);
    const auto last = frames.back();
    frames.pop_back();
    feed(frames);
    feed(frames_of(Auxiliary{.hdop = 0.75F, .vdop = 1.5F}, 40, 1'001'000));
    ASSERT_EQ(feed({last}), 1U);
    EXPECT_EQ(newest.eph, 1.5F);
}

TEST_F(Gnss, an_impossible_fix_is_dropped_and_the_next_one_taken) {
    Fix2 far = fix();
    far.latitude_deg_1e8 = 9'000'000'001;
    EXPECT_EQ(feed(frames_of(far, 40, 1'000'000, 0)), 0U);
    EXPECT_EQ(node.counters().undecodable, 1U);
    Fix2 wild = fix();
    wild.ned_velocity[1] = 1001.0F;
    EXPECT_EQ(feed(frames_of(wild, 40, 1'200'000, 1)), 0U);
    EXPECT_EQ(feed(frames_of(fix(), 40, 1'400'000, 2)), 1U);
}

TEST_F(Gnss, each_field_has_its_bounds) {
    uint64_t now_us = 1'000'000;
    uint8_t transfer_id = 0;
    const auto takes = [&](auto change) {
        Fix2 changed = fix();
        change(changed);
        return feed(frames_of(changed, 40, now_us += 200'000, transfer_id++)) == 1;
    };
    EXPECT_TRUE(takes([](Fix2& f) { f.latitude_deg_1e8 = -9'000'000'000; }));
    EXPECT_FALSE(takes([](Fix2& f) { f.latitude_deg_1e8 = -9'000'000'001; }));
    EXPECT_TRUE(takes([](Fix2& f) { f.longitude_deg_1e8 = 18'000'000'000; }));
    EXPECT_FALSE(takes([](Fix2& f) { f.longitude_deg_1e8 = 18'000'000'001; }));
    EXPECT_FALSE(takes([](Fix2& f) { f.longitude_deg_1e8 = -18'000'000'001; }));
    EXPECT_FALSE(takes([](Fix2& f) { f.height_msl_mm = 60'000'001; }));
    EXPECT_FALSE(takes([](Fix2& f) { f.height_msl_mm = -1'000'001; }));
    for (unsigned i = 0; i < 3; ++i) {
        EXPECT_FALSE(takes([&](Fix2& f) { f.ned_velocity[i] = 1000.5F; }));
    }
    EXPECT_TRUE(takes([](Fix2& f) {
        f.covariance.assign(std::array{-1.0F, 1.0F, 1.0F, 1.0F, 1.0F, 1.0F});
    }));
    EXPECT_TRUE(math::is_nan(newest.eph)) << "a variance below 0 tells nothing";
    const uint32_t before = node.counters().undecodable;
    feed(frames_of(Auxiliary{.hdop = -1.0F, .vdop = 1.0F}, 40, now_us));
    feed(frames_of(Auxiliary{.hdop = 1.0F, .vdop = 1000.5F}, 40, now_us, 1));
    EXPECT_EQ(node.counters().undecodable, before + 2);
    EXPECT_TRUE(takes([](Fix2&) {}));
    EXPECT_TRUE(math::is_nan(newest.eph)) << "and neither does an impossible geometry";
}

TEST_F(Gnss, a_velocity_that_is_unknown_leaves_the_position) {
    for (unsigned axis = 0; axis < 3; ++axis) {
        Fix2 message = fix();
        message.covariance.assign(std::array{4.0F, 4.0F, 9.0F, 0.25F, 0.25F, 0.25F});
        message.ned_velocity[axis] = kUnknown;
        ASSERT_EQ(feed(frames_of(message, 40, 1'000'000, static_cast<uint8_t>(axis))), 1U);
        EXPECT_EQ(newest.latitude_deg, 47.397742);
        EXPECT_EQ(newest.eph, 2.0F);
        EXPECT_FALSE(newest.vel_ned_valid);
        EXPECT_TRUE(math::is_nan(newest.vel_n_m_s + newest.vel_e_m_s + newest.vel_d_m_s));
    }
    EXPECT_EQ(node.counters().undecodable, 0U);
    ASSERT_EQ(feed(frames_of(fix(), 40, 1'200'000, 3)), 1U);
    EXPECT_TRUE(newest.vel_ned_valid);
}

TEST_F(Gnss, a_variance_that_is_unknown_leaves_the_others) {
    uint8_t transfer_id = 0;
    const auto with_unknown = [&](std::size_t index) {
        Fix2 message = fix();
        std::array variances{4.0F, 4.0F, 9.0F, 0.25F, 0.25F, 0.25F};
        variances[index] = kUnknown;
        message.covariance.assign(variances);
        return feed(frames_of(message, 40, 1'000'000, transfer_id++)) == 1;
    };
    ASSERT_TRUE(with_unknown(1));
    EXPECT_TRUE(math::is_nan(newest.eph));
    EXPECT_EQ(newest.epv, 3.0F);
    EXPECT_EQ(newest.s_variance_m_s, 0.5F);
    ASSERT_TRUE(with_unknown(2));
    EXPECT_EQ(newest.eph, 2.0F);
    EXPECT_TRUE(math::is_nan(newest.epv));
    ASSERT_TRUE(with_unknown(3));
    EXPECT_EQ(newest.eph, 2.0F);
    EXPECT_TRUE(math::is_nan(newest.s_variance_m_s));
    EXPECT_TRUE(newest.vel_ned_valid);
    ASSERT_TRUE(with_unknown(4)) << "which nothing here reads";
    EXPECT_EQ(newest.s_variance_m_s, 0.5F);
    feed(frames_of(Auxiliary{.hdop = 0.75F, .vdop = 1.5F}, 40, 1'000'000));
    ASSERT_TRUE(with_unknown(0));
    EXPECT_EQ(newest.eph, 1.5F) << "the geometry tells what the fix does not";
    EXPECT_EQ(newest.epv, 3.0F);
}

TEST_F(Gnss, a_geometry_that_knows_one_of_two_gives_that_one) {
    feed(frames_of(Auxiliary{.hdop = 0.75F, .vdop = kUnknown}, 40, 1'000'000));
    ASSERT_EQ(feed(frames_of(fix(), 40, 1'000'000)), 1U);
    EXPECT_EQ(newest.eph, 1.5F);
    EXPECT_TRUE(math::is_nan(newest.epv));
    feed(frames_of(Auxiliary{.hdop = kUnknown, .vdop = 1.5F}, 40, 1'200'000, 1));
    ASSERT_EQ(feed(frames_of(fix(), 40, 1'200'000, 1)), 1U);
    EXPECT_TRUE(math::is_nan(newest.eph)) << "the newest geometry counts";
    EXPECT_EQ(newest.epv, 3.0F);
    EXPECT_EQ(node.counters().undecodable, 0U);
}

TEST_F(Gnss, a_second_receiver_is_heard_once_the_first_is_silent) {
    EXPECT_EQ(feed(frames_of(fix(), 40, 1'000'000)), 1U);
    EXPECT_EQ(feed(frames_of(fix(), 41, 1'200'000)), 0U);
    EXPECT_EQ(feed(frames_of(fix(), 41, 4'300'000, 1)), 1U);
}

}  // namespace
}  // namespace stator::apps::can_gnss
