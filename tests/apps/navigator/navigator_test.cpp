// The navigator: which goals each mode makes, when a mission moves on, and when it cannot be flown.
#include "navigator.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <optional>
#include <vector>

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
        add(ItemKind::kTakeoff, 0.0F, 0.0F, 5.0F);
    }

    // In metres from home; the parameters of a command are set by hand.
    RawItem& add(ItemKind kind, float north, float east, float height, float hold = 0.0F) {
        RawItem item{.command = static_cast<uint16_t>(kind),
                     .frame = Frame::kLocal,
                     .continues = true,
                     .param = {hold, 1.0F, 0.0F, kNaN},
                     .x = math::saturate<int32_t>(north * 1e4F),
                     .y = math::saturate<int32_t>(east * 1e4F),
                     .z = -height};
        lists_[0].push_back(item);
        return lists_[0].back();
    }
    // A command without a place.
    void add(ItemKind kind, std::array<float, 4> param) {
        add(kind, 0.0F, 0.0F, 0.0F).param = param;
        lists_[0].back().frame = Frame::kMission;
    }
    void add_fence(FenceKind kind, float parameter, float north, float east, float height = 0.0F) {
        RawItem item{.command = static_cast<uint16_t>(kind),
                     .frame = Frame::kLocal,
                     .continues = true,
                     .param = {parameter, 0.0F, 0.0F, 0.0F},
                     .x = math::saturate<int32_t>(north * 1e4F),
                     .y = math::saturate<int32_t>(east * 1e4F),
                     .z = height == 0.0F ? kNaN : -height};
        lists_[1].push_back(item);
    }
    void add_rally_point(float north, float east, float height) {
        RawItem item{.command = 5100,
                     .frame = Frame::kLocal,
                     .continues = true,
                     .param = {},
                     .x = math::saturate<int32_t>(north * 1e4F),
                     .y = math::saturate<int32_t>(east * 1e4F),
                     .z = -height};
        lists_[2].push_back(item);
    }
    // Another content is another id.
    void change() { ++version_; }

    void step() {
        now_us_ += 20'000;
        const auto id = [this](unsigned list) {
            return lists_[list].empty() ? 0 : 100 * version_ + list;
        };
        const auto count = [this](unsigned list) {
            return static_cast<uint16_t>(lists_[list].size());
        };
        const Mission mission{.mission_id = id(0),
                              .geofence_id = id(1),
                              .safe_points_id = id(2),
                              .count = count(0),
                              .geofence_count = count(1),
                              .safe_points_count = count(2)};
        NavigatorPorts ports{.now = now_us_,
                             .status = Input(status_),
                             .mission = has_mission_ ? Input(mission) : Input<Mission>(),
                             .items = has_items_ ? Input(items_) : Input<MissionItems>(),
                             .position = Input(position_),
                             .home = Input(home_),
                             .progress = Input(progress_),
                             .command = command_ ? Input(*command_) : Input<VehicleCommand>(),
                             .params = Input(params_)};
        testing::Probe goal(ports.goal, now_us_);
        testing::Probe result(ports.result, now_us_);
        testing::Probe request(ports.request, now_us_);
        testing::Probe fence(ports.fence, now_us_);
        node_.step(ports);
        command_.reset();
        goal_ = goal.newest();
        result_ = result.newest();
        fence_ = fence.newest();
        if (request.count() != 0) answer(request.newest(), mission);
    }
    // As the mission device does.
    void answer(const MissionRequest& request, const Mission& mission) {
        const auto list = static_cast<unsigned>(request.list);
        const std::array ids{mission.mission_id, mission.geofence_id, mission.safe_points_id};
        ++requests_;
        has_items_ = is_answered_;
        items_ = {.id = ids.at(list), .first = request.first, .list = MissionItems::List(list)};
        for (unsigned i = request.first; i < lists_.at(list).size() && items_.count < 16; ++i) {
            const RawItem& item = lists_[list][i];
            const unsigned at = items_.count++;
            items_.command[at] = item.command;
            items_.frame[at] = static_cast<uint8_t>(item.frame);
            items_.autocontinue[at] = item.continues ? 1 : 0;
            items_.param1[at] = item.param[0];
            items_.param2[at] = item.param[1];
            items_.param3[at] = item.param[2];
            items_.param4[at] = item.param[3];
            items_.x[at] = item.x;
            items_.y[at] = item.y;
            items_.z[at] = item.z;
        }
    }
    void run(float seconds) {
        for (float t = 0.0F; t < seconds; t += 0.02F) step();
    }
    void fly(Nav mode) {
        if (now_us_ == 0) run(0.5F);
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

    std::array<std::vector<RawItem>, 3> lists_;  // mission, fence, rally points
    unsigned version_ = 1;
    MissionItems items_{};
    std::optional<VehicleCommand> command_;
    bool has_items_ = false;
    bool is_answered_ = true;
    unsigned requests_ = 0;
    Navigator node_;
    VehicleStatus status_{};
    VehicleLocalPosition position_{};
    HomePosition home_{};
    TrajectoryProgress progress_{};
    NavigatorParams params_{};
    GotoSetpoint goal_{};
    MissionResult result_{};
    GeofenceResult fence_{};
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
    add(ItemKind::kEight, 10.0F, 0.0F, 5.0F).param = {6.0F, 3.0F, 3.0F, 0.5F};
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

using Fault = MissionResult::Fault;

TEST_F(NavigatorTest, a_mission_is_valid_once_all_items_were_looked_at) {
    for (unsigned i = 0; i < 100; ++i) add(ItemKind::kWaypoint, 10.0F, 0.0F, 5.0F);
    step();
    EXPECT_FALSE(result_.valid);
    EXPECT_EQ(result_.fault, Fault::kUnread);
    run(0.2F);
    EXPECT_TRUE(result_.valid) << "101 items are 7 windows of 16, one in each step";
    EXPECT_EQ(requests_, 7U);
    has_mission_ = false;
    step();
    EXPECT_FALSE(result_.valid);
}

TEST_F(NavigatorTest, ten_thousand_items_are_looked_at_within_13_s) {
    for (unsigned i = 1; i < 10000; ++i) add(ItemKind::kWaypoint, 10.0F, 0.0F, 5.0F);
    run(12.4F);
    EXPECT_FALSE(result_.valid);
    run(0.6F);
    EXPECT_TRUE(result_.valid);
}

// What is wrong with the second item, the item and the fault.
void expect_fault(const MissionResult& result, Fault fault, unsigned item) {
    EXPECT_FALSE(result.valid);
    EXPECT_EQ(result.fault, fault);
    EXPECT_EQ(result.fault_seq, item);
}

TEST_F(NavigatorTest, without_items_there_is_no_mission) {
    lists_[0].clear();
    run(0.2F);
    expect_fault(result_, Fault::kMissing, 0);
}

TEST_F(NavigatorTest, an_unknown_item_or_one_without_a_place_on_a_known_earth_is_named) {
    add(ItemKind::kWaypoint, 10.0F, 0.0F, 5.0F).command = 99;
    run(0.2F);
    expect_fault(result_, Fault::kUnknownCommand, 1);
    lists_[0][1].command = 16;
    lists_[0][1].frame = Frame(10);
    change();
    run(0.2F);
    expect_fault(result_, Fault::kUnknownFrame, 1);
}

TEST_F(NavigatorTest, what_lies_too_far_or_outside_the_fence_is_named) {
    add(ItemKind::kWaypoint, 100.0F, 0.0F, 5.0F);
    run(0.2F);
    EXPECT_TRUE(result_.valid);
    params_.fence_radius = 50.0F;
    change();
    run(0.2F);
    expect_fault(result_, Fault::kTooFar, 1);
    params_.fence_radius = 500.0F;
    params_.farthest = 50.0F;
    change();
    run(0.2F);
    expect_fault(result_, Fault::kTooFar, 1);
    params_.farthest = 1000.0F;
    params_.fence_height = 4.0F;
    change();
    run(0.2F);
    expect_fault(result_, Fault::kTooHigh, 0);
    params_.fence_height = 120.0F;
    add_fence(FenceKind::kCircleInclusion, 50.0F, 0.0F, 0.0F);
    change();
    run(0.2F);
    expect_fault(result_, Fault::kOutsideFence, 1);
}

TEST_F(NavigatorTest, the_missions_own_ceiling_takes_the_place_of_the_usual_one) {
    add(ItemKind::kWaypoint, 10.0F, 0.0F, 150.0F);
    run(0.2F);
    expect_fault(result_, Fault::kTooHigh, 1);
    add_fence(FenceKind::kCircleInclusion, 0.0F, 0.0F, 0.0F, 200.0F);
    change();
    run(0.2F);
    EXPECT_TRUE(result_.valid);
}

TEST_F(NavigatorTest, of_an_eight_the_tips_count_too) {
    add(ItemKind::kEight, 45.0F, 0.0F, 5.0F).param = {6.0F, 3.0F, 1.0F, 0.0F};
    add_fence(FenceKind::kCircleInclusion, 50.0F, 0.0F, 0.0F);
    run(0.2F);
    expect_fault(result_, Fault::kOutsideFence, 1);
}

// Shorter, its curve is sharper than any acceleration allows; none at all would divide by zero.
TEST_F(NavigatorTest, an_eight_shorter_than_2_m_is_not_valid) {
    add(ItemKind::kEight, 10.0F, 0.0F, 5.0F);
    for (const float length : {0.0F, 1.9F, -10.0F, kNaN}) {
        lists_[0][1].param = {0.5F * length, 1.0F, 1.0F, 0.0F};
        change();
        run(0.2F);
        EXPECT_FALSE(result_.valid) << length;
    }
    lists_[0][1].param[0] = 1.0F;
    change();
    run(0.2F);
    EXPECT_TRUE(result_.valid);
}

TEST_F(NavigatorTest, a_hold_that_is_infinite_is_not_valid) {
    add(ItemKind::kWaypoint, 10.0F, 0.0F, 5.0F, std::numeric_limits<float>::infinity());
    run(0.2F);
    expect_fault(result_, Fault::kBadValue, 1);
}

TEST_F(NavigatorTest, a_landing_counts_for_distance_and_fence_too) {
    add(ItemKind::kLand, 100.0F, 0.0F, 0.0F);
    run(0.2F);
    EXPECT_TRUE(result_.valid);
    add_fence(FenceKind::kCircleInclusion, 50.0F, 0.0F, 0.0F);
    change();
    run(0.2F);
    expect_fault(result_, Fault::kOutsideFence, 1);
}

TEST_F(NavigatorTest, what_is_not_above_home_is_not_valid) {
    add(ItemKind::kWaypoint, 10.0F, 0.0F, 0.0F);
    run(0.2F);
    expect_fault(result_, Fault::kBelowHome, 1);
}

TEST_F(NavigatorTest, a_jump_that_leads_nowhere_is_not_valid) {
    for (const float target : {-1.0F, 1.0F, 2.0F, kNaN}) {
        lists_[0].resize(1);
        add(ItemKind::kJump, {target, 1.0F, 0.0F, 0.0F});
        change();
        run(0.2F);
        expect_fault(result_, Fault::kBadJump, 1);
    }
}

TEST_F(NavigatorTest, an_area_that_excludes_lets_nothing_through) {
    const auto draw = [this](float north) {
        lists_[1].clear();
        for (const auto& [x, y] :
             {std::pair(0.0F, -5.0F), {10.0F, -5.0F}, {10.0F, 5.0F}, {0.0F, 5.0F}}) {
            add_fence(FenceKind::kPolygonExclusion, 4.0F, north + x, y);
        }
        change();
        run(0.3F);
    };
    add(ItemKind::kWaypoint, 50.0F, 0.0F, 5.0F);
    draw(45.0F);
    expect_fault(result_, Fault::kOutsideFence, 1);
    draw(20.0F);
    expect_fault(result_, Fault::kLeavesFence, 1);
    draw(60.0F);
    EXPECT_TRUE(result_.valid);
}

TEST_F(NavigatorTest, of_areas_that_include_one_is_enough) {
    add_fence(FenceKind::kCircleInclusion, 10.0F, 0.0F, 0.0F);
    lists_[1][0].frame = Frame::kGlobal;  // or else it would be about home
    position_.xy_global = true;
    position_.ref_lat = 47.0;
    position_.ref_lon = 8.0;
    lists_[1][0].x = 470000000;
    lists_[1][0].y = 80000000;
    for (const auto& [x, y] :
         {std::pair(5.0F, -5.0F), {40.0F, -5.0F}, {40.0F, 5.0F}, {5.0F, 5.0F}}) {
        add_fence(FenceKind::kPolygonInclusion, 4.0F, x, y);
    }
    position_.x = position_.y = 0.0F;
    home_.x = home_.y = 0.0F;
    add(ItemKind::kWaypoint, 35.0F, 0.0F, 5.0F);
    run(0.3F);
    EXPECT_TRUE(result_.valid) << static_cast<int>(result_.fault);
    lists_[0][1].y = 80000;  // 8 m east
    change();
    run(0.3F);
    expect_fault(result_, Fault::kOutsideFence, 1);
}

TEST_F(NavigatorTest, a_fence_with_half_a_polygon_is_not_valid) {
    add_fence(FenceKind::kPolygonInclusion, 4.0F, 100.0F, 0.0F);
    add_fence(FenceKind::kPolygonInclusion, 4.0F, 0.0F, 100.0F);
    run(0.3F);
    EXPECT_EQ(result_.fault, Fault::kBadFence);
}

TEST_F(NavigatorTest, it_says_how_the_vehicle_left_the_fence) {
    fly(Nav::kHold);
    EXPECT_FALSE(fence_.geofence_max_dist_triggered);
    position_.x = 1.0F + params_.fence_radius + 1.0F;
    step();
    EXPECT_TRUE(fence_.geofence_max_dist_triggered);
    position_.x = 1.0F;
    position_.z = 0.5F - params_.fence_height - 1.0F;
    step();
    EXPECT_TRUE(fence_.geofence_max_alt_triggered);
    position_.z = 0.5F;
    add_fence(FenceKind::kCircleExclusion, 5.0F, 0.0F, 0.0F);
    step();
    run(0.2F);
    EXPECT_TRUE(fence_.geofence_custom_fence_triggered);
    status_.arming_state = VehicleStatus::ArmingState::kDisarmed;
    step();
    EXPECT_FALSE(fence_.geofence_custom_fence_triggered) << "on the ground it does not count";
}

// --- other items ---

TEST_F(NavigatorTest, a_jump_repeats_and_then_goes_on) {
    add(ItemKind::kWaypoint, 10.0F, 0.0F, 5.0F);
    add(ItemKind::kWaypoint, 20.0F, 0.0F, 5.0F);
    add(ItemKind::kJump, {1.0F, 2.0F, 0.0F, 0.0F});
    add(ItemKind::kWaypoint, 30.0F, 0.0F, 5.0F);
    fly(Nav::kMission);
    run(2.0F);
    std::vector<int> reached;
    for (int i = 0; i < 20; ++i) {
        arrive();
        step();
        if (reached.empty() || reached.back() != result_.seq_reached) {
            reached.push_back(result_.seq_reached);
        }
    }
    EXPECT_EQ(reached, (std::vector{0, 1, 2, 1, 2, 1, 2, 4}));
}

TEST_F(NavigatorTest, jumps_that_lead_round_do_not_hang) {
    add(ItemKind::kJump, {2.0F, -1.0F, 0.0F, 0.0F});
    add(ItemKind::kJump, {1.0F, -1.0F, 0.0F, 0.0F});
    fly(Nav::kMission);
    run(2.0F);
    arrive();
    run(1.0F);
    EXPECT_EQ(result_.seq_reached, 0);
}

TEST_F(NavigatorTest, a_change_of_speed_has_a_type) {
    add(ItemKind::kChangeSpeed, {1.0F, 3.0F, -1.0F, 0.0F});
    add(ItemKind::kChangeSpeed, {2.0F, 0.7F, -1.0F, 0.0F});
    add(ItemKind::kChangeSpeed, {3.0F, 0.4F, -1.0F, 0.0F});
    add(ItemKind::kWaypoint, 10.0F, 0.0F, 15.0F);
    add(ItemKind::kWaypoint, 10.0F, 0.0F, 5.0F);
    add(ItemKind::kChangeSpeed, {1.0F, -2.0F, -1.0F, 0.0F});
    add(ItemKind::kChangeSpeed, {3.0F, -1.0F, -1.0F, 0.0F});
    add(ItemKind::kWaypoint, 20.0F, 0.0F, 3.0F);
    fly(Nav::kMission);
    run(2.0F);
    EXPECT_TRUE(math::is_nan(goal_.max_horizontal_speed));
    arrive();
    step();
    EXPECT_EQ(goal_.max_horizontal_speed, 3.0F);
    EXPECT_EQ(goal_.max_vertical_speed, 0.7F);
    arrive();
    step();
    EXPECT_EQ(goal_.max_vertical_speed, 0.4F);
    arrive();
    step();
    EXPECT_TRUE(math::is_nan(goal_.max_horizontal_speed)) << "-2: as usual";
    EXPECT_EQ(goal_.max_vertical_speed, 0.4F) << "-1: no change";
}

TEST_F(NavigatorTest, it_looks_at_a_region_of_interest_all_the_way) {
    add(ItemKind::kRegionOfInterestLocation, 0.0F, 10.0F, 0.0F);
    add(ItemKind::kWaypoint, 20.0F, 0.0F, 5.0F);
    add(ItemKind::kRegionOfInterestNone, {0.0F, 0.0F, 0.0F, 0.0F});
    add(ItemKind::kWaypoint, 40.0F, 0.0F, 5.0F);
    fly(Nav::kMission);
    run(2.0F);
    arrive();
    run(0.1F);
    EXPECT_NEAR(goal_.heading, math::kHalfPi<float>, 1e-3F);
    position_.x = 1.0F + 10.0F;
    step();
    EXPECT_NEAR(goal_.heading, 0.75F * math::kPi<float>, 1e-3F);
    arrive();
    run(0.1F);
    EXPECT_NEAR(goal_.heading, 0.0F, 1e-3F);
}

TEST_F(NavigatorTest, a_condition_waits_on_the_way_to_the_next_place) {
    add(ItemKind::kConditionDistance, {8.0F, 0.0F, 0.0F, 0.0F});
    add(ItemKind::kChangeSpeed, {1.0F, 1.0F, -1.0F, 0.0F});
    add(ItemKind::kWaypoint, 20.0F, 0.0F, 5.0F);
    fly(Nav::kMission);
    run(2.0F);
    arrive();
    step();
    expect_goal(21.0F, 2.0F, -4.5F);
    EXPECT_TRUE(math::is_nan(goal_.max_horizontal_speed));
    position_.x = 1.0F + 13.0F;
    step();
    expect_goal(21.0F, 2.0F, -4.5F);
    EXPECT_EQ(goal_.max_horizontal_speed, 1.0F);
}

TEST_F(NavigatorTest, a_delay_condition_counts_from_the_place_before) {
    add(ItemKind::kConditionDelay, {2.0F, 0.0F, 0.0F, 0.0F});
    add(ItemKind::kChangeSpeed, {1.0F, 1.0F, -1.0F, 0.0F});
    add(ItemKind::kWaypoint, 20.0F, 0.0F, 5.0F);
    fly(Nav::kMission);
    run(2.0F);
    arrive();
    run(1.5F);
    EXPECT_TRUE(math::is_nan(goal_.max_horizontal_speed));
    run(1.0F);
    EXPECT_EQ(goal_.max_horizontal_speed, 1.0F);
}

TEST_F(NavigatorTest, a_condition_of_yaw_turns_the_nose) {
    add(ItemKind::kConditionYaw, {90.0F, 0.0F, 0.0F, 0.0F});
    add(ItemKind::kWaypoint, 20.0F, 0.0F, 5.0F);
    add(ItemKind::kWaypoint, 40.0F, 0.0F, 5.0F);
    fly(Nav::kMission);
    run(2.0F);
    arrive();
    run(0.1F);
    EXPECT_NEAR(goal_.heading, math::kHalfPi<float>, 1e-3F);
    arrive();
    run(0.1F);
    EXPECT_NEAR(goal_.heading, 0.0F, 1e-3F);
}

TEST_F(NavigatorTest, a_delay_holds_where_the_vehicle_is) {
    add(ItemKind::kDelay, {3.0F, 0.0F, 0.0F, 0.0F});
    add(ItemKind::kWaypoint, 20.0F, 0.0F, 5.0F);
    fly(Nav::kMission);
    run(2.0F);
    arrive();
    step();
    expect_goal(1.0F, 2.0F, -4.5F);
    arrive();
    run(2.8F);
    EXPECT_EQ(result_.seq_reached, 0);
    run(0.5F);
    EXPECT_EQ(result_.seq_reached, 1);
}

TEST_F(NavigatorTest, a_change_of_altitude_is_straight_up_or_down) {
    add(ItemKind::kWaypoint, 20.0F, 0.0F, 5.0F);
    add(ItemKind::kConditionChangeAltitude, {0.3F, 0.0F, 0.0F, 0.0F});
    lists_[0].back().frame = Frame::kRelative;
    lists_[0].back().z = 12.0F;
    fly(Nav::kMission);
    run(2.0F);
    arrive();
    arrive();
    step();
    expect_goal(21.0F, 2.0F, 0.5F - 12.0F);
    EXPECT_EQ(goal_.max_vertical_speed, 0.3F);
}

TEST_F(NavigatorTest, loiter_turns_begin_at_the_nearest_point_of_their_circle) {
    add(ItemKind::kLoiterTurns, 20.0F, 0.0F, 5.0F).param = {2.0F, 0.0F, -5.0F, 0.0F};
    fly(Nav::kMission);
    run(2.0F);
    arrive();
    step();
    expect_goal(1.0F + 15.0F, 2.0F, -4.5F);
    arrive();
    EXPECT_EQ(goal_.kind, Kind::kCircle);
    EXPECT_EQ(goal_.length, 5.0F);
    EXPECT_EQ(goal_.laps, -2.0F) << "a radius below 0 turns anticlockwise";
    EXPECT_NEAR(goal_.position[0], 21.0F, 1e-3F);
    EXPECT_EQ(result_.seq_reached, 0);
    position_.x = 16.0F;
    progress_ = {.goal = goal_.number, .is_done = true};
    step();
    EXPECT_EQ(result_.seq_reached, 1);
}

TEST_F(NavigatorTest, what_no_device_does_is_passed_by) {
    add(ItemKind(206), {25.0F, 0.0F, 1.0F, 0.0F});
    add(ItemKind(530), {0.0F, 2.0F, kNaN, kNaN});
    add(ItemKind::kWaypoint, 20.0F, 0.0F, 5.0F);
    fly(Nav::kMission);
    run(2.0F);
    arrive();
    step();
    expect_goal(21.0F, 2.0F, -4.5F);
    EXPECT_EQ(result_.seq_current, 3);
}

TEST_F(NavigatorTest, without_a_take_off_it_climbs_to_its_first_place_first) {
    lists_[0].clear();
    add(ItemKind::kWaypoint, 20.0F, 0.0F, 7.0F);
    fly(Nav::kMission);
    run(2.0F);
    expect_goal(1.0F, 2.0F, 0.5F - 7.0F);
    arrive();
    expect_goal(21.0F, 2.0F, 0.5F - 7.0F);
}

TEST_F(NavigatorTest, a_waypoint_that_noise_keeps_away_is_passed_after_a_time) {
    add(ItemKind::kWaypoint, 20.0F, 0.0F, 5.0F).param[1] = 0.2F;
    add(ItemKind::kWaypoint, 40.0F, 0.0F, 5.0F);
    fly(Nav::kMission);
    run(2.0F);
    arrive();
    step();
    progress_ = {.goal = goal_.number, .is_done = true};
    position_.x = 21.0F + 0.9F;
    run(3.5F);
    EXPECT_EQ(result_.seq_reached, 0);
    run(1.0F);
    EXPECT_EQ(result_.seq_reached, 1);
}

// --- how a mission ends ---

TEST_F(NavigatorTest, without_autocontinue_it_waits_and_goes_on_when_asked) {
    add(ItemKind::kWaypoint, 20.0F, 0.0F, 5.0F).continues = false;
    add(ItemKind::kWaypoint, 40.0F, 0.0F, 5.0F);
    fly(Nav::kMission);
    run(2.0F);
    arrive();
    step();
    arrive();
    EXPECT_TRUE(result_.finished);
    EXPECT_TRUE(result_.waits);
    EXPECT_EQ(result_.next_nav_state, static_cast<uint8_t>(Nav::kHold));
    fly(Nav::kHold);
    EXPECT_TRUE(result_.waits);
    run(5.0F);
    EXPECT_FALSE(result_.finished);
    fly(Nav::kMission);
    step();
    expect_goal(41.0F, 2.0F, -4.5F);
    EXPECT_FALSE(result_.waits);
}

TEST_F(NavigatorTest, a_mission_that_ends_in_the_air_holds_and_then_returns) {
    fly(Nav::kMission);
    run(2.0F);
    arrive();
    run(0.1F);
    EXPECT_TRUE(result_.waits);
    fly(Nav::kHold);
    run(params_.wait_limit - 1.0F);
    EXPECT_FALSE(result_.finished);
    run(1.5F);
    EXPECT_TRUE(result_.finished);
    EXPECT_EQ(result_.next_nav_state, static_cast<uint8_t>(Nav::kReturn));
}

TEST_F(NavigatorTest, the_pilots_own_hold_lasts) {
    fly(Nav::kHold);
    run(params_.wait_limit + 5.0F);
    EXPECT_FALSE(result_.finished);
}

TEST_F(NavigatorTest, a_return_leads_to_the_nearest_of_home_and_rally_points) {
    add_rally_point(100.0F, 0.0F, 12.0F);
    add_rally_point(40.0F, 10.0F, 20.0F);
    fly(Nav::kHold);
    position_.x = 36.0F;
    position_.z = -5.5F;
    fly(Nav::kReturn);
    expect_goal(36.0F, 2.0F, 0.5F - 20.0F);
    EXPECT_NEAR(result_.land_x, 41.0F, 1e-3F);
    arrive();
    expect_goal(41.0F, 12.0F, 0.5F - 20.0F);
    arrive();
    EXPECT_EQ(result_.next_nav_state, static_cast<uint8_t>(Nav::kLand));
    fly(Nav::kLand);
    EXPECT_NEAR(result_.land_y, 12.0F, 1e-3F) << "where it was to land";
}

TEST_F(NavigatorTest, a_rally_point_outside_the_fence_is_not_valid) {
    add_rally_point(100.0F, 0.0F, 12.0F);
    add_fence(FenceKind::kCircleInclusion, 50.0F, 0.0F, 0.0F);
    run(0.3F);
    expect_fault(result_, Fault::kBadRallyPoint, 0);
}

TEST_F(NavigatorTest, a_return_stays_below_the_ceiling) {
    params_.fence_height = 5.0F;
    position_.x = 31.0F;
    position_.z = -1.5F;
    fly(Nav::kReturn);
    expect_goal(31.0F, 2.0F, 0.5F - 4.5F);
}

TEST_F(NavigatorTest, speeds_of_the_mission_hold_for_its_return_too) {
    add(ItemKind::kChangeSpeed, {1.0F, 2.0F, -1.0F, 0.0F});
    add(ItemKind::kReturn, {0.0F, 0.0F, 0.0F, 0.0F});
    fly(Nav::kMission);
    run(2.0F);
    arrive();
    run(0.1F);
    position_.x = 31.0F;
    fly(Nav::kReturn);
    EXPECT_EQ(goal_.max_horizontal_speed, 2.0F);
    fly(Nav::kHold);
    fly(Nav::kReturn);
    EXPECT_TRUE(math::is_nan(goal_.max_horizontal_speed))
        << "the pilot's return is not the mission's";
}

TEST_F(NavigatorTest, a_landing_that_cannot_reach_its_place_goes_down_all_the_same) {
    position_.z = -9.5F;
    fly(Nav::kLand);
    run(5.1F);
    expect_goal(1.0F, 2.0F, 0.5F - params_.landing_height);
    run(5.2F);
    EXPECT_EQ(goal_.kind, Kind::kLand);
}

// --- in flight ---

TEST_F(NavigatorTest, another_mission_in_the_air_is_looked_at_before_its_next_item) {
    add(ItemKind::kWaypoint, 10.0F, 0.0F, 5.0F);
    add(ItemKind::kWaypoint, 20.0F, 0.0F, 5.0F);
    fly(Nav::kMission);
    run(2.0F);
    arrive();
    step();
    lists_[0][2].x = 300000;
    change();
    step();
    EXPECT_TRUE(result_.valid);
    expect_goal(11.0F, 2.0F, -4.5F);
    arrive();
    run(0.1F);
    expect_goal(31.0F, 2.0F, -4.5F);
}

TEST_F(NavigatorTest, a_bad_mission_in_the_air_counts_as_lost) {
    add(ItemKind::kWaypoint, 10.0F, 0.0F, 5.0F);
    fly(Nav::kMission);
    run(2.0F);
    lists_[0][1].command = 99;
    change();
    run(0.2F);
    expect_fault(result_, Fault::kUnknownCommand, 1);
}

TEST_F(NavigatorTest, a_device_that_falls_silent_in_the_air_counts_as_lost) {
    for (int i = 0; i < 30; ++i) add(ItemKind::kWaypoint, 10.0F, 0.0F, 5.0F, 0.1F);
    fly(Nav::kMission);
    run(2.0F);
    is_answered_ = false;
    for (int i = 0; i < 40; ++i) arrive();
    EXPECT_TRUE(result_.valid);
    for (int i = 0; i < 200; ++i) arrive();
    EXPECT_EQ(result_.fault, Fault::kUnread);
}

TEST_F(NavigatorTest, a_shorter_mission_that_comes_in_flight_is_over) {
    add(ItemKind::kWaypoint, 10.0F, 0.0F, 5.0F);
    add(ItemKind::kWaypoint, 20.0F, 0.0F, 5.0F);
    fly(Nav::kMission);
    run(2.0F);
    arrive();
    step();
    arrive();
    step();
    EXPECT_EQ(result_.seq_current, 2);
    lists_[0].resize(2);
    change();
    step();
    arrive();
    run(0.2F);
    EXPECT_TRUE(result_.finished);
    EXPECT_EQ(result_.next_nav_state, static_cast<uint8_t>(Nav::kHold));
}

// A minute of latitude is 1853.2 m at 47.4 degrees: the meridian's radius there is 6,370.2 km.
TEST_F(NavigatorTest, a_place_on_earth_is_found_from_the_frames_place) {
    RawItem& item = add(ItemKind::kWaypoint, 0.0F, 0.0F, 0.0F, 1.0F);
    item.frame = Frame::kRelative;
    item.x = 474016667;  // 0.1 minutes north
    item.y = 85000000;
    item.z = 5.0F;
    position_.ref_lat = 47.4;
    position_.ref_lon = 8.5;
    run(0.2F);
    expect_fault(result_, Fault::kNoPosition, 0);
    position_.xy_global = true;
    run(0.2F);
    fly(Nav::kMission);
    run(2.0F);
    arrive();
    step();
    EXPECT_NEAR(goal_.position[0], 185.3F, 0.1F);
    EXPECT_NEAR(goal_.position[1], 0.0F, 0.1F);
}

TEST_F(NavigatorTest, a_height_above_the_sea_needs_the_frames_height) {
    RawItem& item = add(ItemKind::kWaypoint, 0.0F, 0.0F, 0.0F, 1.0F);
    item.frame = Frame::kGlobal;
    item.x = 474001000;
    item.y = 85000000;
    item.z = 512.0F;
    position_.xy_global = true;
    position_.ref_lat = 47.4;
    position_.ref_lon = 8.5;
    run(0.2F);
    expect_fault(result_, Fault::kNoPosition, 0);
    position_.z_global = true;
    position_.ref_alt = 500.0F;
    run(0.2F);
    fly(Nav::kMission);
    run(2.0F);
    arrive();
    step();
    EXPECT_NEAR(goal_.position[2], -12.0F, 1e-3F);
}

// --- commands ---

TEST_F(NavigatorTest, HoldsAtThePlaceOfACommandAndKeepsWhatIsNotGiven) {
    fly(Nav::kHold);
    EXPECT_EQ(goal_.kind, Kind::kStop);
    command_ = VehicleCommand{
        .action = VehicleCommand::Action::kGo, .position = {10.0F, kNaN, -7.0F}, .heading = 1.5F};
    step();
    expect_goal(10.0F, 2.0F, -7.0F);
    EXPECT_EQ(goal_.heading, 1.5F);
    status_.nav_state = Nav::kReturn;
    step();
    const uint32_t number = goal_.number;
    command_ = VehicleCommand{.action = VehicleCommand::Action::kGo};
    step();
    EXPECT_EQ(goal_.number, number);
}

TEST_F(NavigatorTest, orbits_a_place_until_something_else_is_wished_for) {
    fly(Nav::kHold);
    command_ = VehicleCommand{.action = VehicleCommand::Action::kOrbit,
                              .position = {21.0F, 2.0F, -9.0F},
                              .radius = -5.0F,
                              .speed = 3.0F,
                              .faces_centre = true};
    step();
    expect_goal(16.0F, 2.0F, -9.0F);  // the nearest place
    EXPECT_EQ(goal_.max_horizontal_speed, 3.0F);
    EXPECT_NEAR(goal_.heading, 0.0F, 1e-3F);
    position_.x = 16.0F;
    arrive();
    step();
    EXPECT_EQ(goal_.kind, Kind::kCircle);
    EXPECT_EQ(goal_.position[0], 21.0F);
    EXPECT_EQ(goal_.length, 5.0F);
    EXPECT_LT(goal_.laps, -10.0F) << "anticlockwise";
    position_.x = 21.0F;
    position_.y = 7.0F;
    step();
    EXPECT_NEAR(goal_.heading, -math::kHalfPi<float>, 1e-3F) << "it looks at the middle";
    const uint32_t number = goal_.number;
    arrive();
    step();
    EXPECT_EQ(goal_.number, number + 1) << "after all laps it goes on";
    EXPECT_EQ(goal_.kind, Kind::kCircle);
    command_ = VehicleCommand{
        .action = VehicleCommand::Action::kGo, .position = {10.0F, 0.0F, -7.0F}, .heading = kNaN};
    step();
    EXPECT_EQ(goal_.kind, Kind::kPosition);
    arrive();
    step();
    EXPECT_EQ(goal_.kind, Kind::kPosition) << "the orbit is over";
}

TEST_F(NavigatorTest, another_mode_ends_an_orbit) {
    fly(Nav::kHold);
    command_ = VehicleCommand{
        .action = VehicleCommand::Action::kOrbit, .position = {kNaN, kNaN, kNaN}, .radius = 5.0F};
    step();
    status_.nav_state = Nav::kPosition;
    step();
    status_.nav_state = Nav::kHold;
    step();
    arrive();
    step();
    EXPECT_EQ(goal_.kind, Kind::kStop);
}

TEST_F(NavigatorTest, TakesOffToTheHeightOfTheCommand) {
    run(0.5F);
    command_ = VehicleCommand{.action = VehicleCommand::Action::kSetMode,
                              .nav_state = static_cast<uint8_t>(Nav::kTakeoff),
                              .position = {kNaN, kNaN, -11.5F}};
    step();
    fly(Nav::kTakeoff);
    run(2.0F);
    expect_goal(1.0F, 2.0F, -11.5F);
}

// Zero above the sea, from a station that leaves the height open.
TEST_F(NavigatorTest, TakesOffToTheUsualHeightIfTheCommandsIsBelowTheGround) {
    run(0.5F);
    command_ = VehicleCommand{.action = VehicleCommand::Action::kSetMode,
                              .nav_state = static_cast<uint8_t>(Nav::kTakeoff),
                              .position = {kNaN, kNaN, 490.0F}};
    step();
    fly(Nav::kTakeoff);
    run(2.0F);
    expect_goal(1.0F, 2.0F, 0.5F - params_.takeoff_height);
}

TEST_F(NavigatorTest, GoesOnWithTheItemOfACommand) {
    add(ItemKind::kWaypoint, 10.0F, 0.0F, 5.0F);
    add(ItemKind::kWaypoint, 10.0F, 10.0F, 5.0F);
    run(1.0F);
    command_ = VehicleCommand{.action = VehicleCommand::Action::kSetItem, .item = 2};
    step();
    EXPECT_EQ(result_.seq_current, 2);
    fly(Nav::kMission);
    run(3.0F);
    position_.z = -6.0F;  // up first, then there
    arrive();
    step();
    EXPECT_EQ(result_.seq_current, 2);
    expect_goal(11.0F, 12.0F, -4.5F);
    command_ = VehicleCommand{.action = VehicleCommand::Action::kSetItem, .item = 1};
    step();
    step();
    EXPECT_EQ(result_.seq_current, 1);
    expect_goal(11.0F, 2.0F, -4.5F);
}

}  // namespace
}  // namespace stator::apps::navigator
