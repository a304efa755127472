// From the ground into the air, to goals, and what it does without them.
#include "fw_guidance.hpp"

#include <gtest/gtest.h>

#include "stator/testing.hpp"

namespace stator::apps::fw_guidance {
namespace {

using Nav = VehicleStatus::NavState;
using Kind = GotoSetpoint::Kind;

class FwGuidanceTest : public ::testing::Test {
  protected:
    FwGuidanceTest() {
        params_.period = 10.0F;
        params_.damping = 0.7F;
        params_.loiter_radius = 80.0F;
        params_.height_acceptance = 8.0F;
        params_.trim_airspeed = 17.0F;
        params_.takeoff_airspeed = 12.0F;
        params_.takeoff_pitch = 0.17F;
        params_.takeoff_time = 1.5F;
        params_.runway_pitch = 0.1F;
        params_.clearance = 10.0F;
        params_.abort_length = 120.0F;
        params_.wheel_gain = 1.5F;
        params_.landing_slope = 0.0873F;
        params_.landing_airspeed = 14.0F;
        params_.approach_height = 20.0F;
        params_.flare_height = 3.0F;
        params_.flare_sink = 0.4F;
        params_.lands_into_wind = true;
        position_.xy_valid = position_.z_valid = position_.v_xy_valid = position_.v_z_valid = true;
        step();
        status_.arming_state = VehicleStatus::ArmingState::kArmed;
        home_.valid_lpos = true;
        step();
    }
    void go(Kind kind, float north, float east, float height) {
        ++goal_.number;
        goal_.kind = kind;
        goal_.position = {north, east, -height};
        has_goal_ = true;
    }
    void step(float seconds = 0.02F) {
        for (float t = 0.0F; t < seconds - 0.01F; t += 0.02F) {
            now_us_ += 20'000;
            FwGuidancePorts ports{.now = now_us_,
                                  .goal = has_goal_ ? Input(goal_) : Input<GotoSetpoint>(),
                                  .position = Input(position_),
                                  .airspeed = Input(airspeed_),
                                  .wind = Input(wind_),
                                  .status = Input(status_),
                                  .land = Input(land_),
                                  .home = Input(home_),
                                  .sticks = Input(sticks_),
                                  .params = Input(params_)};
            testing::Probe lateral(ports.lateral, now_us_);
            testing::Probe longitudinal(ports.longitudinal, now_us_);
            testing::Probe setpoint(ports.setpoint, now_us_);
            testing::Probe progress(ports.progress, now_us_);
            node_.step(ports);
            lateral_ = lateral.newest();
            longitudinal_ = longitudinal.newest();
            progress_ = progress.newest();
        }
    }
    // In the air at 40 m, northwards; a take-off is over.
    void be_in_the_air() {
        go(Kind::kPosition, 0.0F, 0.0F, 40.0F);
        land_.landed = false;
        step();
        position_.z = -5.0F;
        position_.vx = 17.0F;
        airspeed_.true_airspeed_m_s = airspeed_.calibrated_airspeed_m_s = 17.0F;
        step(0.1F);
        position_.z = -40.0F;
        step(0.1F);
    }

    FwGuidance node_;
    FwGuidanceParams params_{};
    GotoSetpoint goal_{};
    VehicleLocalPosition position_{};
    AirspeedValidated airspeed_{};
    AirspeedWind wind_{};
    VehicleStatus status_{.arming_state = VehicleStatus::ArmingState::kDisarmed,
                          .nav_state = Nav::kMission};
    VehicleLandDetected land_{.landed = true};
    HomePosition home_{};
    ManualControlSetpoint sticks_{};
    FixedWingLateralSetpoint lateral_{};
    FixedWingLongitudinalSetpoint longitudinal_{};
    TrajectoryProgress progress_{};
    bool has_goal_ = false;
    uint64_t now_us_ = 0;
};

TEST_F(FwGuidanceTest, StandsUntilAGoalIsAbove) {
    step(1.0F);
    EXPECT_EQ(longitudinal_.throttle_direct, 0.0F);
    go(Kind::kPosition, 100.0F, 0.0F, 0.0F);
    step(1.0F);
    EXPECT_EQ(longitudinal_.throttle_direct, 0.0F);
    go(Kind::kPosition, 0.0F, 0.0F, 40.0F);
    step(2.0F);
    EXPECT_EQ(longitudinal_.throttle_direct, 1.0F);
    EXPECT_TRUE(math::is_finite(lateral_.yaw_rate));
}

TEST_F(FwGuidanceTest, NothingButAStartLeavesTheGround) {
    status_.nav_state = Nav::kReturn;
    go(Kind::kPosition, 0.0F, 0.0F, 40.0F);
    step(3.0F);
    EXPECT_EQ(longitudinal_.throttle_direct, 0.0F);
}

TEST_F(FwGuidanceTest, RotatesAtNineTenthsOfTheTakeOffAirspeed) {
    go(Kind::kPosition, 0.0F, 0.0F, 40.0F);
    airspeed_.calibrated_airspeed_m_s = 10.7F;
    step(3.0F);
    EXPECT_NEAR(longitudinal_.pitch_direct, 0.1F, 1e-5F);
    airspeed_.calibrated_airspeed_m_s = 10.9F;
    step(2.0F);
    EXPECT_NEAR(longitudinal_.pitch_direct, 0.17F, 1e-5F);
}

// Publicly reported: with a blocked pitot it never rotated, and ran off the end of the runway.
TEST_F(FwGuidanceTest, GivesUpATakeOffThatIsTooLong) {
    go(Kind::kPosition, 0.0F, 0.0F, 40.0F);
    step(3.0F);
    position_.x = 121.0F;
    step(0.1F);
    EXPECT_EQ(longitudinal_.throttle_direct, 0.0F);
    position_.x = 130.0F;
    step(1.0F);
    EXPECT_EQ(longitudinal_.throttle_direct, 0.0F);
}

TEST_F(FwGuidanceTest, ATakeOffIsDoneAtItsHeight) {
    be_in_the_air();
    EXPECT_TRUE(progress_.is_done);
    EXPECT_EQ(progress_.goal, goal_.number);
    EXPECT_NEAR(longitudinal_.altitude, 40.0F, 1e-4F);
    EXPECT_FALSE(math::is_finite(lateral_.yaw_rate));
}

// 17^2 / (9.80665 tan 0.7) = 35.0 m is the radius of a turn with 0.7 rad of bank, and half a
// second 8.5 m.
TEST_F(FwGuidanceTest, AGoalIsReachedWhereTheTurnBegins) {
    be_in_the_air();
    go(Kind::kPosition, 250.0F, 0.0F, 40.0F);
    step();
    position_.x = 204.0F;
    step(0.1F);
    EXPECT_FALSE(progress_.is_done);
    position_.x = 208.0F;
    step(0.1F);
    EXPECT_TRUE(progress_.is_done);
    go(Kind::kPosition, 250.0F, 250.0F, 40.0F);
    step(0.1F);
    EXPECT_FALSE(progress_.is_done);
    EXPECT_GT(lateral_.lateral_acceleration, 3.0F);
}

TEST_F(FwGuidanceTest, AGoalThatIsTooHighIsCircled) {
    be_in_the_air();
    go(Kind::kPosition, 250.0F, 0.0F, 80.0F);
    position_.x = 235.0F;
    step(0.2F);
    EXPECT_FALSE(progress_.is_done);
    position_.z = -75.0F;
    step(0.1F);
    EXPECT_TRUE(progress_.is_done);
}

TEST_F(FwGuidanceTest, CirclesAreCounted) {
    be_in_the_air();
    go(Kind::kCircle, 0.0F, 0.0F, 40.0F);
    goal_.length = 100.0F;
    goal_.laps = 1.0F;
    for (float turned = 0.0F; turned < 6.0F; turned += 0.1F) {
        position_.x = 100.0F * math::cos(turned);
        position_.y = 100.0F * math::sin(turned);
        step();
    }
    EXPECT_FALSE(progress_.is_done);
    for (float turned = 6.0F; turned < 6.5F; turned += 0.1F) {
        position_.x = 100.0F * math::cos(turned);
        position_.y = 100.0F * math::sin(turned);
        step();
    }
    EXPECT_TRUE(progress_.is_done);
}

TEST_F(FwGuidanceTest, LandsAgainstTheWind) {
    be_in_the_air();
    wind_ = {.windspeed_north = 0.0F, .windspeed_east = 8.0F, .valid = true};
    status_.nav_state = Nav::kLand;
    go(Kind::kLand, 0.0F, 0.0F, 40.0F);
    goal_.heading = math::canonical_nan<float>();
    // On the slope, 100 m east of the place, westwards.
    position_.x = 0.0F;
    position_.y = 228.0F;
    position_.z = -20.0F;
    position_.vx = 0.0F;
    position_.vy = -10.0F;
    step(0.1F);
    position_.y = 104.9F;  // 6 m/s over ground flare 4.9 m further than the slope
    position_.z = -8.75F;
    step(0.1F);
    // 10 m/s down 5 deg.
    EXPECT_NEAR(longitudinal_.height_rate, -0.875F, 0.1F);
    EXPECT_NEAR(longitudinal_.equivalent_airspeed, 14.0F, 1e-5F);
}

TEST_F(FwGuidanceTest, WithoutAPositionItCirclesDown) {
    be_in_the_air();
    status_.nav_state = Nav::kDescend;
    step();
    EXPECT_EQ(longitudinal_.throttle_direct, 0.0F);
    EXPECT_TRUE(math::is_nan(longitudinal_.altitude) && math::is_nan(longitudinal_.height_rate));
    EXPECT_NEAR(math::atan(lateral_.lateral_acceleration / 9.80665F), 0.26F, 1e-3F);
    position_.z = -2.0F;
    step();
    EXPECT_EQ(lateral_.lateral_acceleration, 0.0F);
    EXPECT_GT(longitudinal_.pitch_direct, 0.0F);
}

TEST_F(FwGuidanceTest, SinkingFarBelowItsHeightItCannotFollow) {
    be_in_the_air();
    step(1.0F);
    EXPECT_EQ(progress_.lags_for, 0.0F);
    position_.z = -30.0F;
    position_.vz = 1.5F;
    step(5.0F);
    EXPECT_NEAR(progress_.lags_for, 5.0F, 0.1F);
    position_.vz = -1.0F;
    step();
    EXPECT_EQ(progress_.lags_for, 0.0F);
}

}  // namespace
}  // namespace stator::apps::fw_guidance
