// The trajectory: profiles and plans keep their limits, the node never jumps.
#include "trajectory.hpp"

#include <gtest/gtest.h>

#include "stator/random.hpp"
#include "stator/testing.hpp"

namespace stator::apps::trajectory {
namespace {

using math::Vector3;

// --- profiles ---

struct Worst {
    float speed = 0.0F;
    float acceleration = 0.0F;
    float jerk = 0.0F;
};

// Also expects that distance, speed and acceleration belong together.
Worst walk(const Profile& profile) {
    constexpr float kStep = 1e-3F;
    Worst worst;
    Along before = profile.at(0.0F);
    for (float t = kStep; t < profile.duration(); t += kStep) {
        const Along now = profile.at(t);
        const float mean_speed = 0.5F * (before.speed + now.speed);
        EXPECT_NEAR(now.distance - before.distance, mean_speed * kStep, 2e-5F);
        worst.speed = math::max(worst.speed, now.speed);
        worst.acceleration = math::max(worst.acceleration, math::abs(now.acceleration));
        worst.jerk =
            math::max(worst.jerk, math::abs(now.acceleration - before.acceleration) / kStep);
        before = now;
    }
    return worst;
}

// Lengths for which the limits of speed, of acceleration, and only of jerk are reached.
TEST(ProfileTest, keeps_its_limits_and_ends_at_rest) {
    constexpr ProfileLimits kLimits{5.0F, 3.0F, 8.0F};
    for (const float length : {0.01F, 0.5F, 3.0F, 9.0F, 40.0F}) {
        const Profile profile(length, kLimits);
        const Worst worst = walk(profile);
        EXPECT_LE(worst.speed, kLimits.speed * 1.001F) << length;
        EXPECT_LE(worst.acceleration, kLimits.acceleration * 1.001F) << length;
        EXPECT_LE(worst.jerk, kLimits.jerk * 1.05F) << length;
        const Along end = profile.at(profile.duration() + 1.0F);
        EXPECT_NEAR(end.distance, length, 1e-5F * (1.0F + length));
        EXPECT_NEAR(end.speed, 0.0F, 1e-6F);
    }
}

// By hand: 40 m at 5 m/s, 3 m/s^2, 8 m/s^3. Speeding up takes A/J + V/A = 0.375 + 1.667 s, and all
// of it L/V + that.
TEST(ProfileTest, takes_the_time_of_the_closed_form) {
    const Profile profile(40.0F, {5.0F, 3.0F, 8.0F});
    EXPECT_NEAR(profile.duration(), 40.0F / 5.0F + 0.375F + 5.0F / 3.0F, 1e-4F);
    EXPECT_NEAR(profile.at(0.5F * profile.duration()).distance, 20.0F, 1e-3F);
}

TEST(ProfileTest, no_way_takes_no_time) {
    const Profile profile(0.0F, {5.0F, 3.0F, 8.0F});
    EXPECT_EQ(profile.duration(), 0.0F);
    EXPECT_EQ(profile.at(1.0F).distance, 0.0F);
}

// --- plans ---

constexpr ProfileLimits kLimits{5.0F, 3.0F, 8.0F};

// Along any state: position, velocity and acceleration belong together, and nothing jumps. Fading,
// stopping and leaving each have the limit of jerk to themselves.
void expect_smooth(const MotionPlan& plan, const PathState& start) {
    constexpr float kStep = 1e-3F;
    PathState before = plan.at(0.0F);
    EXPECT_LT(math::norm(before.position - start.position), 1e-4F);
    EXPECT_LT(math::norm(before.velocity - start.velocity), 1e-4F);
    EXPECT_LT(math::norm(before.acceleration - start.acceleration), 1e-4F);
    for (float t = kStep; t < plan.duration(); t += kStep) {
        const PathState now = plan.at(t);
        const Vector3<float> moved = 0.5F * kStep * (before.velocity + now.velocity);
        const Vector3<float> gained = 0.5F * kStep * (before.acceleration + now.acceleration);
        ASSERT_LT(math::norm(now.position - before.position - moved), 5e-5F) << t;
        ASSERT_LT(math::norm(now.velocity - before.velocity - gained), 5e-5F) << t;
        ASSERT_LT(math::norm(now.acceleration - before.acceleration), 3.1F * kLimits.jerk * kStep);
        before = now;
    }
}

TEST(MotionPlanTest, leads_smoothly_from_any_state_to_rest_at_the_goal) {
    math::Random random(3);
    for (int trial = 0; trial < 20; ++trial) {
        PathState start;
        Vector3<float> goal;
        for (int i = 0; i < 3; ++i) {
            start.position[i] = random.gaussian_float();
            start.velocity[i] = 2.0F * random.gaussian_float();
            start.acceleration[i] = random.gaussian_float();
            goal[i] = 10.0F * random.gaussian_float();
        }
        const Stop stop(start, kLimits);
        const MotionPlan plan(stop, Leg::line(goal - stop.rest(), kLimits));
        expect_smooth(plan, start);
        const PathState end = plan.at(plan.duration());
        EXPECT_LT(math::norm(end.position - goal), 1e-3F);
        EXPECT_LT(math::norm(end.velocity), 1e-4F);
    }
}

// A waypoint on the way: the next leg begins when this one begins to brake, and together they keep
// the speed, as each brakes as the other gains.
TEST(MotionPlanTest, a_leg_that_leads_on_keeps_the_speed) {
    const MotionPlan first(Stop{}, Leg::line({20.0F, 0.0F, 0.0F}, kLimits));
    const float braking = SpeedUp(kLimits).duration();
    const PathState there = first.at(first.duration() - braking);
    const Stop stop(there, kLimits);
    EXPECT_NEAR(stop.rest().x(), 20.0F, 1e-2F);
    const MotionPlan second(stop, Leg::line({20.0F, 0.0F, 0.0F}, kLimits));
    for (float t = 0.0F; t < 3.0F; t += 0.1F) {
        EXPECT_NEAR(second.at(t).velocity.x(), 5.0F, 1e-2F) << t;
    }
}

TEST(MotionPlanTest, a_leg_that_leads_back_waits_for_the_stop) {
    PathState start;
    start.velocity.x() = 5.0F;
    const Stop stop(start, kLimits);
    const MotionPlan plan(stop, Leg::line({-20.0F, 0.0F, 0.0F}, kLimits));
    for (float t = 0.0F; t < plan.duration(); t += 0.01F) {
        EXPECT_LT(math::norm(plan.at(t).acceleration), kLimits.acceleration * 1.001F);
    }
}

TEST(LegTest, an_eight_is_as_long_and_wide_and_fast_as_wanted_and_comes_back) {
    const Leg leg = Leg::eight(0.0F, 10.0F, 2.0F, {5.0F, 1.0F, 8.0F});
    float length = 0.0F;
    float width = 0.0F;
    float speed = 0.0F;
    for (float t = 0.0F; t < leg.duration(); t += 0.01F) {
        const PathState now = leg.at(t);
        length = math::max(length, 2.0F * math::abs(now.position.x()));
        width = math::max(width, 2.0F * math::abs(now.position.y()));
        speed = math::max(speed, math::norm(now.velocity));
    }
    EXPECT_NEAR(length, 10.0F, 0.01F);
    EXPECT_NEAR(width, 5.0F, 0.01F);
    EXPECT_NEAR(speed, 5.0F, 0.01F);
    EXPECT_LT(math::norm(leg.at(leg.duration()).position), 1e-3F);
}

TEST(LegTest, a_circle_keeps_its_radius_its_speed_and_its_side) {
    for (const float turns : {2.0F, -2.0F}) {
        // East of the middle.
        const Leg leg = Leg::circle(math::kHalfPi<float>, 10.0F, turns, {2.0F, 1.0F, 8.0F});
        float speed = 0.0F;
        for (float t = 0.0F; t < leg.duration(); t += 0.01F) {
            const PathState now = leg.at(t);
            const Vector3<float> from_middle = now.position + Vector3<float>(0.0F, 10.0F, 0.0F);
            EXPECT_NEAR(math::norm(from_middle), 10.0F, 1e-3F);
            EXPECT_LT(math::norm(now.acceleration), 1.1F);
            speed = math::max(speed, math::norm(now.velocity));
        }
        EXPECT_NEAR(speed, 2.0F, 0.01F);
        // Clockwise as seen from above, which is from north over east to south.
        EXPECT_LT(turns * leg.at(3.0F).velocity.x(), 0.0F);
        EXPECT_LT(math::norm(leg.at(leg.duration()).position), 1e-2F);
    }
}

TEST(LegTest, a_small_circle_is_flown_as_slowly_as_its_acceleration_wants) {
    const Leg leg = Leg::circle(0.0F, 1.0F, 3.0F, {5.0F, 1.0F, 8.0F});
    EXPECT_LT(math::norm(leg.at(0.5F * leg.duration()).velocity), 1.01F);
}

// --- the node ---

class TrajectoryTest : public ::testing::Test {
  protected:
    using Nav = VehicleStatus::NavState;

    TrajectoryTest() {
        status_.arming_state = VehicleStatus::ArmingState::kArmed;
        status_.nav_state = Nav::kHold;
        position_.xy_valid = position_.z_valid = true;
        position_.v_xy_valid = position_.v_z_valid = true;
        sticks_.valid = true;
    }

    void step() {
        now_us_ += 10'000;
        TrajectoryPorts ports{
            .now = now_us_,
            .goal = has_goal_ ? Input(goal_) : Input<GotoSetpoint>(),
            .position = Input(position_),
            .status = Input(status_),
            .sticks = has_sticks_ ? Input(sticks_) : Input<ManualControlSetpoint>(),
            .params = Input(params_)};
        testing::Probe setpoint(ports.setpoint, now_us_);
        testing::Probe progress(ports.progress, now_us_);
        node_.step(ports);
        setpoint_ = setpoint.newest();
        progress_ = progress.newest();
        if (follows_ && math::is_finite(setpoint_.position[0])) {
            position_.x = setpoint_.position[0];
            position_.y = setpoint_.position[1];
            position_.z = setpoint_.position[2];
        }
    }
    void run(float seconds) {
        for (float t = 0.0F; t < seconds; t += 0.01F) step();
    }
    void go_to(float north, float east, float down) {
        has_goal_ = true;
        ++goal_.number;
        goal_.kind = GotoSetpoint::Kind::kPosition;
        goal_.position = {north, east, down};
        goal_.heading = 1.0F;
        goal_.max_horizontal_speed = math::canonical_nan<float>();
        goal_.max_vertical_speed = math::canonical_nan<float>();
    }

    Trajectory node_;
    GotoSetpoint goal_{};
    VehicleLocalPosition position_{};
    VehicleStatus status_{};
    ManualControlSetpoint sticks_{};
    TrajectoryParams params_{};
    TrajectorySetpoint setpoint_{};
    TrajectoryProgress progress_{};
    uint64_t now_us_ = 0;
    bool has_goal_ = false;
    bool has_sticks_ = true;
    bool follows_ = true;
};

TEST_F(TrajectoryTest, leaves_all_free_while_disarmed_or_without_a_goal) {
    step();
    EXPECT_TRUE(math::is_nan(setpoint_.position[0]));
    go_to(10.0F, 0.0F, -5.0F);
    status_.arming_state = VehicleStatus::ArmingState::kDisarmed;
    step();
    EXPECT_TRUE(math::is_nan(setpoint_.velocity[2]));
}

TEST_F(TrajectoryTest, comes_to_rest_at_the_goal_with_its_heading_and_says_so) {
    go_to(10.0F, -5.0F, -5.0F);
    step();
    EXPECT_FALSE(progress_.is_done);
    run(15.0F);
    EXPECT_TRUE(progress_.is_done);
    EXPECT_EQ(progress_.goal, goal_.number);
    EXPECT_NEAR(setpoint_.position[0], 10.0F, 1e-2F);
    EXPECT_NEAR(setpoint_.position[1], -5.0F, 1e-2F);
    EXPECT_NEAR(setpoint_.position[2], -5.0F, 1e-2F);
    EXPECT_NEAR(setpoint_.yaw, 1.0F, 1e-2F);
}

// In flight to somewhere, each other goal, stop and mode goes on from where the setpoint is.
TEST_F(TrajectoryTest, never_jumps) {
    math::Random random(7);
    go_to(30.0F, 0.0F, -10.0F);
    run(4.0F);
    TrajectorySetpoint before = setpoint_;
    constexpr std::array kModes{Nav::kHold, Nav::kMission, Nav::kPosition, Nav::kReturn};
    for (int i = 0; i < 2000; ++i) {
        if (i % 60 == 0) go_to(20.0F * random.gaussian_float(), 5.0F, -10.0F);
        if (i % 150 == 0) goal_.kind = GotoSetpoint::Kind::kStop;
        if (i % 200 == 0) status_.nav_state = kModes[static_cast<unsigned>(i / 200) % 4];
        sticks_.roll = 0.7F;
        step();
        const Vector3<float> moved =
            math::vector(setpoint_.position) - math::vector(before.position);
        const Vector3<float> gained =
            math::vector(setpoint_.velocity) - math::vector(before.velocity);
        ASSERT_LT(math::norm(moved), 0.12F) << i;   // 10 ms at 12 m/s
        ASSERT_LT(math::norm(gained), 0.09F) << i;  // 10 ms at 9 m/s^2
        before = setpoint_;
    }
}

TEST_F(TrajectoryTest, waits_for_a_vehicle_that_lags) {
    follows_ = false;
    go_to(30.0F, 0.0F, 0.0F);
    run(20.0F);
    EXPECT_LT(setpoint_.position[0], params_.lag_limit);
    EXPECT_GT(setpoint_.position[0], 0.5F * params_.lag_limit);
    EXPECT_FALSE(progress_.is_done);
    follows_ = true;
    run(20.0F);
    EXPECT_NEAR(setpoint_.position[0], 30.0F, 0.01F);
}

TEST_F(TrajectoryTest, a_landing_goes_on_down) {
    go_to(0.0F, 0.0F, -5.0F);
    run(8.0F);
    ++goal_.number;
    goal_.kind = GotoSetpoint::Kind::kLand;
    run(5.0F);
    EXPECT_NEAR(setpoint_.velocity[2], params_.landing_rate, 1e-3F);
    EXPECT_FALSE(progress_.is_done);
}

TEST_F(TrajectoryTest, sticks_are_speeds_where_the_nose_points) {
    status_.nav_state = Nav::kPosition;
    position_.heading = math::kHalfPi<float>;  // the nose to the east
    status_.arming_state = VehicleStatus::ArmingState::kDisarmed;
    step();
    status_.arming_state = VehicleStatus::ArmingState::kArmed;
    sticks_.pitch = 1.0F;
    sticks_.throttle = 0.5F;
    run(6.0F);
    EXPECT_NEAR(setpoint_.velocity[0], 0.0F, 0.02F);
    EXPECT_NEAR(setpoint_.velocity[1], params_.speed, 0.02F);
    EXPECT_NEAR(setpoint_.velocity[2], -0.5F * params_.climb_rate, 0.02F);
    sticks_ = {};
    sticks_.valid = true;
    run(6.0F);
    EXPECT_NEAR(setpoint_.velocity[1], 0.0F, 0.02F);
}

TEST_F(TrajectoryTest, sticks_that_are_not_heard_want_nothing) {
    status_.nav_state = Nav::kPosition;
    sticks_.pitch = 1.0F;
    sticks_.valid = false;
    run(3.0F);
    EXPECT_NEAR(setpoint_.velocity[0], 0.0F, 1e-3F);
}

TEST_F(TrajectoryTest, altitude_mode_leans_and_leaves_the_place_free) {
    status_.nav_state = Nav::kAltitude;
    sticks_.roll = 1.0F;
    run(1.0F);
    EXPECT_TRUE(math::is_nan(setpoint_.position[0]));
    EXPECT_TRUE(math::is_nan(setpoint_.velocity[1]));
    // 9.80665 m/s^2 * tan(0.4)
    EXPECT_NEAR(setpoint_.acceleration[1], 4.146F, 0.01F);
    EXPECT_TRUE(math::is_finite(setpoint_.position[2]));
}

TEST_F(TrajectoryTest, altitude_mode_takes_no_place_that_is_not_known) {
    position_.x = 3.0F;
    status_.nav_state = Nav::kAltitude;
    step();
    position_.xy_valid = false;
    position_.x = math::canonical_nan<float>();
    step();
    status_.nav_state = Nav::kPosition;
    step();
    EXPECT_NEAR(setpoint_.position[0], 3.0F, 1e-3F);
    EXPECT_NEAR(setpoint_.position[1], 0.0F, 1e-3F);
}

TEST_F(TrajectoryTest, a_goal_that_is_not_finite_stops_at_the_place) {
    go_to(10.0F, -5.0F, -5.0F);
    run(15.0F);
    go_to(math::canonical_nan<float>(), 0.0F, -5.0F);
    for (const float length : {0.0F, math::canonical_nan<float>()}) {
        run(1.0F);
        EXPECT_NEAR(setpoint_.position[0], 10.0F, 1e-2F);
        EXPECT_NEAR(setpoint_.velocity[1], 0.0F, 1e-3F);
        EXPECT_TRUE(progress_.is_done);
        ++goal_.number;
        goal_.kind = GotoSetpoint::Kind::kEight;
        goal_.length = length;
        goal_.laps = 2.0F;
    }
    run(1.0F);
    EXPECT_NEAR(setpoint_.position[0], 10.0F, 1e-2F);
}

TEST_F(TrajectoryTest, descend_sinks_without_a_place) {
    status_.nav_state = Nav::kDescend;
    step();
    EXPECT_TRUE(math::is_nan(setpoint_.position[0]));
    EXPECT_TRUE(math::is_nan(setpoint_.position[2]));
    EXPECT_EQ(setpoint_.velocity[2], params_.landing_rate);
}

}  // namespace
}  // namespace stator::apps::trajectory
