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
    wild.ned_velocity[1] = math::canonical_nan<float>();
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
        EXPECT_FALSE(takes([&](Fix2& f) { f.ned_velocity[i] = math::canonical_nan<float>(); }));
    }
    EXPECT_FALSE(takes([](Fix2& f) {
        f.covariance.assign(std::array{1.0F, 1.0F, 1.0F, 1.0F, math::canonical_nan<float>(), 1.0F});
    }));
    EXPECT_TRUE(takes([](Fix2& f) {
        f.covariance.assign(std::array{-1.0F, 1.0F, 1.0F, 1.0F, 1.0F, 1.0F});
    }));
    EXPECT_TRUE(math::is_nan(newest.eph)) << "a variance below 0 tells nothing";
    EXPECT_FALSE(feed(frames_of(Auxiliary{.hdop = math::canonical_nan<float>()}, 40, now_us)));
    EXPECT_TRUE(takes([](Fix2&) {}));
    EXPECT_TRUE(math::is_nan(newest.eph)) << "and neither does a geometry that is no number";
}

TEST_F(Gnss, a_second_receiver_is_heard_once_the_first_is_silent) {
    EXPECT_EQ(feed(frames_of(fix(), 40, 1'000'000)), 1U);
    EXPECT_EQ(feed(frames_of(fix(), 41, 1'200'000)), 0U);
    EXPECT_EQ(feed(frames_of(fix(), 41, 4'300'000, 1)), 1U);
}

}  // namespace
}  // namespace stator::apps::can_gnss
