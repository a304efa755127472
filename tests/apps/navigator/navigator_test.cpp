// The navigator: which goals each mode makes, when a mission moves on, and when it cannot be flown.
#include "navigator.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "stator/testing.hpp"

namespace stator::apps::navigator {
namespace {

using Nav = VehicleStatus::NavState;
using Kind = GotoSetpoint::Kind;
constexpr float kNaN = math::canonical_nan<float>();

class NavigatorTest : public ::testing::Test {
  protected:
    NavigatorTest() {
        position_.xy_valid = position_.z_valid = true;
        position_.x = 1.0F;
        position_.y = 2.0F;
        position_.z = 0.5F;
        home_ = {.x = 1.0F, .y = 2.0F, .z = 0.5F, .yaw = 0.0F, .valid_lpos = true};
        mission_.origin_lat = mission_.origin_lon = math::canonical_nan<double>();
        add(ItemKind::kTakeoff, 0.0F, 0.0F, 5.0F);
    }

    void add(ItemKind kind, float north, float east, float height, float hold = 0.0F) {
        const unsigned i = mission_.count++;
        mission_.kind[i] = static_cast<uint8_t>(kind);
        mission_.north[i] = north;
        mission_.east[i] = east;
        mission_.height[i] = height;
        mission_.heading[i] = kNaN;
        mission_.radius[i] = 1.0F;
        mission_.hold[i] = hold;
        mission_.speed[i] = kNaN;
    }

    void step() {
        now_us_ += 20'000;
        NavigatorPorts ports{.now = now_us_,
                             .status = Input(status_),
                             .mission = has_mission_ ? Input(mission_) : Input<Mission>(),
                             .position = Input(position_),
                             .home = Input(home_),
                             .progress = Input(progress_),
                             .params = Input(params_)};
        testing::Probe goal(ports.goal, now_us_);
        testing::Probe result(ports.result, now_us_);
        node_.step(ports);
        goal_ = goal.newest();
        result_ = result.newest();
    }
    void run(float seconds) {
        for (float t = 0.0F; t < seconds; t += 0.02F) step();
    }
    void fly(Nav mode) {
        status_.arming_state = VehicleStatus::ArmingState::kArmed;
        status_.nav_state = mode;
        step();
    }
    // The vehicle is at the goal, and the trajectory says that it rests there.
    void arrive() {
        position_.x = goal_.position[0];
        position_.y = goal_.position[1];
        position_.z = goal_.position[2];
        progress_ = {.goal = goal_.number, .is_done = true};
        step();
    }
    void expect_goal(float x, float y, float z) {
        EXPECT_EQ(goal_.kind, Kind::kPosition);
        EXPECT_NEAR(goal_.position[0], x, 1e-3F);
        EXPECT_NEAR(goal_.position[1], y, 1e-3F);
        EXPECT_NEAR(goal_.position[2], z, 1e-3F);
    }

    Navigator node_;
    VehicleStatus status_{};
    Mission mission_{};
    VehicleLocalPosition position_{};
    HomePosition home_{};
    TrajectoryProgress progress_{};
    NavigatorParams params_{};
    GotoSetpoint goal_{};
    MissionResult result_{};
    uint64_t now_us_ = 0;
    bool has_mission_ = true;
};

TEST_F(NavigatorTest, hold_stops) {
    fly(Nav::kHold);
    EXPECT_EQ(goal_.kind, Kind::kStop);
    EXPECT_FALSE(result_.finished);
}

TEST_F(NavigatorTest, take_off_waits_then_climbs_straight_up_then_finishes) {
    fly(Nav::kTakeoff);
    run(1.0F);
    EXPECT_EQ(goal_.kind, Kind::kStop);
    run(1.0F);
    expect_goal(1.0F, 2.0F, 0.5F - params_.takeoff_height);
    EXPECT_FALSE(result_.finished);
    arrive();
    EXPECT_TRUE(result_.finished);
    EXPECT_EQ(result_.next_nav_state, static_cast<uint8_t>(Nav::kHold));
}

TEST_F(NavigatorTest, a_mission_counts_from_home_and_looks_where_it_goes) {
    add(ItemKind::kWaypoint, 0.0F, 20.0F, 5.0F, 2.0F);
    fly(Nav::kMission);
    run(2.0F);
    expect_goal(1.0F, 2.0F, -4.5F);
    arrive();
    expect_goal(1.0F, 22.0F, -4.5F);
    EXPECT_NEAR(goal_.heading, math::kHalfPi<float>, 1e-3F);
    EXPECT_EQ(result_.seq_reached, 0);
    EXPECT_EQ(result_.seq_current, 1);
    EXPECT_EQ(result_.seq_total, 2);
}

TEST_F(NavigatorTest, a_hold_lasts_and_then_the_mission_is_over) {
    add(ItemKind::kWaypoint, 10.0F, 0.0F, 5.0F, 2.0F);
    fly(Nav::kMission);
    run(2.0F);
    arrive();
    arrive();
    run(1.5F);
    EXPECT_EQ(result_.seq_reached, 0);
    run(1.0F);
    EXPECT_EQ(result_.seq_reached, 1);
    EXPECT_TRUE(result_.finished);
    EXPECT_EQ(result_.next_nav_state, static_cast<uint8_t>(Nav::kHold));
}

TEST_F(NavigatorTest, without_hold_it_flies_on_from_the_radius) {
    add(ItemKind::kWaypoint, 10.0F, 0.0F, 5.0F);
    add(ItemKind::kWaypoint, 10.0F, 10.0F, 5.0F);
    fly(Nav::kMission);
    run(2.0F);
    arrive();
    position_.x = 1.0F + 8.5F;
    step();
    EXPECT_EQ(result_.seq_reached, 0);
    position_.x = 1.0F + 9.5F;
    step();
    EXPECT_EQ(result_.seq_reached, 1);
    expect_goal(11.0F, 12.0F, -4.5F);
}

// Beyond its radius, a place where it stays counts only after some time: wind may keep it away.
TEST_F(NavigatorTest, a_stop_needs_the_vehicle_near_or_time) {
    add(ItemKind::kWaypoint, 10.0F, 0.0F, 5.0F, 1.0F);
    fly(Nav::kMission);
    run(2.0F);
    arrive();
    progress_ = {.goal = goal_.number, .is_done = true};
    position_.x = 1.0F + 8.0F;
    run(3.0F);
    EXPECT_EQ(result_.seq_reached, 0);
    run(3.0F);
    EXPECT_EQ(result_.seq_reached, 1);
}

TEST_F(NavigatorTest, an_eight_begins_in_its_middle) {
    add(ItemKind::kEight, 10.0F, 0.0F, 5.0F, 3.0F);
    mission_.radius[1] = 12.0F;
    mission_.heading[1] = 0.5F;
    fly(Nav::kMission);
    run(2.0F);
    arrive();
    expect_goal(11.0F, 2.0F, -4.5F);
    arrive();
    EXPECT_EQ(goal_.kind, Kind::kEight);
    EXPECT_EQ(goal_.length, 12.0F);
    EXPECT_EQ(goal_.laps, 3.0F);
    EXPECT_EQ(goal_.heading, 0.5F);
    EXPECT_EQ(result_.seq_reached, 0);
    arrive();
    EXPECT_EQ(result_.seq_reached, 1);
}

TEST_F(NavigatorTest, items_that_end_say_which_mode_follows) {
    add(ItemKind::kReturn, 0.0F, 0.0F, 5.0F);
    fly(Nav::kMission);
    run(2.0F);
    arrive();
    EXPECT_TRUE(result_.finished);
    EXPECT_EQ(result_.next_nav_state, static_cast<uint8_t>(Nav::kReturn));
}

TEST_F(NavigatorTest, a_landing_item_goes_there_first) {
    add(ItemKind::kLand, 10.0F, 0.0F, 5.0F);
    fly(Nav::kMission);
    run(2.0F);
    arrive();
    expect_goal(11.0F, 2.0F, -4.5F);
    EXPECT_FALSE(result_.finished);
    arrive();
    EXPECT_TRUE(result_.finished);
    EXPECT_EQ(result_.next_nav_state, static_cast<uint8_t>(Nav::kLand));
}

TEST_F(NavigatorTest, a_mission_that_was_left_goes_on_with_its_item) {
    add(ItemKind::kWaypoint, 10.0F, 0.0F, 5.0F, 2.0F);
    fly(Nav::kMission);
    run(2.0F);
    arrive();
    fly(Nav::kHold);
    EXPECT_EQ(goal_.kind, Kind::kStop);
    fly(Nav::kMission);
    expect_goal(11.0F, 2.0F, -4.5F);
}

TEST_F(NavigatorTest, arming_again_begins_anew) {
    add(ItemKind::kWaypoint, 10.0F, 0.0F, 5.0F, 2.0F);
    fly(Nav::kMission);
    run(2.0F);
    arrive();
    status_.arming_state = VehicleStatus::ArmingState::kDisarmed;
    step();
    fly(Nav::kMission);
    EXPECT_EQ(result_.seq_reached, -1);
    EXPECT_EQ(result_.seq_current, 0);
}

TEST_F(NavigatorTest, a_return_climbs_goes_home_and_lands) {
    position_.x = 31.0F;
    position_.z = -3.5F;
    fly(Nav::kReturn);
    expect_goal(31.0F, 2.0F, 0.5F - params_.return_height);
    arrive();
    expect_goal(1.0F, 2.0F, 0.5F - params_.return_height);
    EXPECT_NEAR(math::abs(goal_.heading), math::kPi<float>, 1e-3F);
    arrive();
    EXPECT_TRUE(result_.finished);
    EXPECT_EQ(result_.next_nav_state, static_cast<uint8_t>(Nav::kLand));
}

TEST_F(NavigatorTest, a_return_from_above_home_does_not_climb) {
    position_.z = -3.5F;
    fly(Nav::kReturn);
    expect_goal(1.0F, 2.0F, -3.5F);
}

TEST_F(NavigatorTest, a_landing_stops_comes_down_and_then_slows) {
    position_.z = -9.5F;
    fly(Nav::kLand);
    EXPECT_EQ(goal_.kind, Kind::kStop);
    progress_ = {.goal = goal_.number, .is_done = true};
    step();
    expect_goal(1.0F, 2.0F, 0.5F - params_.landing_height);
    arrive();
    EXPECT_EQ(goal_.kind, Kind::kLand);
    EXPECT_FALSE(result_.finished);
}

// --- what can be flown ---

TEST_F(NavigatorTest, a_mission_is_valid_if_it_can_be_flown) {
    add(ItemKind::kWaypoint, 10.0F, 0.0F, 5.0F);
    step();
    EXPECT_TRUE(result_.valid);
    has_mission_ = false;
    step();
    EXPECT_FALSE(result_.valid);
}

TEST_F(NavigatorTest, a_mission_without_items_is_not_valid) {
    mission_.count = 0;
    step();
    EXPECT_FALSE(result_.valid);
}

TEST_F(NavigatorTest, a_mission_that_does_not_begin_with_a_take_off_is_not_valid) {
    mission_.kind[0] = static_cast<uint8_t>(ItemKind::kWaypoint);
    step();
    EXPECT_FALSE(result_.valid);
}

TEST_F(NavigatorTest, an_item_behind_the_end_is_not_valid) {
    add(ItemKind::kReturn, 0.0F, 0.0F, 5.0F);
    add(ItemKind::kWaypoint, 10.0F, 0.0F, 5.0F);
    step();
    EXPECT_FALSE(result_.valid);
}

TEST_F(NavigatorTest, an_unknown_item_or_one_without_a_place_is_not_valid) {
    add(ItemKind::kWaypoint, kNaN, 0.0F, 5.0F);
    step();
    EXPECT_FALSE(result_.valid);
    mission_.north[1] = 10.0F;
    step();
    EXPECT_TRUE(result_.valid);
    mission_.kind[1] = 99;
    step();
    EXPECT_FALSE(result_.valid);
}

TEST_F(NavigatorTest, what_lies_too_far_or_outside_the_fence_is_not_valid) {
    add(ItemKind::kWaypoint, 100.0F, 0.0F, 5.0F);
    step();
    EXPECT_TRUE(result_.valid);
    mission_.fence_radius = 50.0F;
    step();
    EXPECT_FALSE(result_.valid);
    mission_.fence_radius = 0.0F;
    params_.farthest = 50.0F;
    step();
    EXPECT_FALSE(result_.valid);
    params_.farthest = 1000.0F;
    mission_.fence_height = 4.0F;
    step();
    EXPECT_FALSE(result_.valid);
}

TEST_F(NavigatorTest, of_an_eight_the_tips_count_too) {
    add(ItemKind::kEight, 45.0F, 0.0F, 5.0F, 1.0F);
    mission_.radius[1] = 12.0F;
    mission_.fence_radius = 50.0F;
    step();
    EXPECT_FALSE(result_.valid);
}

// Shorter, its curve is sharper than any acceleration allows; none at all would divide by zero.
TEST_F(NavigatorTest, an_eight_shorter_than_2_m_is_not_valid) {
    add(ItemKind::kEight, 10.0F, 0.0F, 5.0F, 1.0F);
    for (const float length : {0.0F, 1.9F, -10.0F, kNaN}) {
        mission_.radius[1] = length;
        step();
        EXPECT_FALSE(result_.valid) << length;
    }
    mission_.radius[1] = 2.0F;
    step();
    EXPECT_TRUE(result_.valid);
}

TEST_F(NavigatorTest, a_hold_that_is_infinite_is_not_valid) {
    add(ItemKind::kWaypoint, 10.0F, 0.0F, 5.0F, std::numeric_limits<float>::infinity());
    step();
    EXPECT_FALSE(result_.valid);
}

TEST_F(NavigatorTest, a_landing_counts_for_distance_and_fence_too) {
    add(ItemKind::kLand, 100.0F, 0.0F, 5.0F);
    step();
    EXPECT_TRUE(result_.valid);
    mission_.fence_radius = 50.0F;
    step();
    EXPECT_FALSE(result_.valid);
    mission_.fence_radius = 0.0F;
    params_.farthest = 50.0F;
    step();
    EXPECT_FALSE(result_.valid);
    params_.farthest = 1000.0F;
    mission_.fence_height = 8.0F;
    mission_.height[1] = 9.0F;
    step();
    EXPECT_FALSE(result_.valid);
}

TEST_F(NavigatorTest, a_take_off_above_the_fence_is_not_valid) {
    mission_.fence_height = 4.0F;
    step();
    EXPECT_FALSE(result_.valid);
}

TEST_F(NavigatorTest, what_is_not_above_home_is_not_valid) {
    add(ItemKind::kWaypoint, 10.0F, 0.0F, 0.0F);
    step();
    EXPECT_FALSE(result_.valid);
    mission_.height[1] = 5.0F;
    mission_.height[0] = -5.0F;
    step();
    EXPECT_FALSE(result_.valid);
}

TEST_F(NavigatorTest, a_shorter_mission_that_comes_in_flight_is_over) {
    add(ItemKind::kWaypoint, 10.0F, 0.0F, 5.0F);
    add(ItemKind::kWaypoint, 20.0F, 0.0F, 5.0F);
    fly(Nav::kMission);
    run(2.0F);
    arrive();
    arrive();
    EXPECT_EQ(result_.seq_current, 2);
    mission_.count = 2;
    step();
    EXPECT_TRUE(result_.finished);
    EXPECT_EQ(result_.next_nav_state, static_cast<uint8_t>(Nav::kHold));
}

// A minute of latitude is 1853.2 m at 47.4 degrees: the meridian's radius there is 6,370.2 km.
TEST_F(NavigatorTest, an_origin_on_earth_is_found_from_the_frames_place) {
    add(ItemKind::kWaypoint, 10.0F, 0.0F, 5.0F, 1.0F);
    position_.ref_lat = 47.4;
    position_.ref_lon = 8.5;
    mission_.origin_lat = 47.4 + 0.1 / 60.0;
    mission_.origin_lon = 8.5;
    step();
    EXPECT_FALSE(result_.valid);
    position_.xy_global = true;
    fly(Nav::kMission);
    run(2.0F);
    arrive();
    EXPECT_NEAR(goal_.position[0], 185.3F + 10.0F, 0.1F);
    EXPECT_NEAR(goal_.position[1], 0.0F, 0.1F);
}

}  // namespace
}  // namespace stator::apps::navigator
