// Attitude control of an aeroplane: coordinated turns, limits, sticks, absent inputs.
#include "fw_attitude.hpp"

#include <gtest/gtest.h>

#include "stator/testing.hpp"

namespace stator::apps::fw_attitude {
namespace {

constexpr float kDegree = math::kPi<float> / 180.0F;

std::array<float, 4> euler(float roll, float pitch, float yaw) {
    return math::to_array(math::from_euler(math::EulerAngles<float>{roll, pitch, yaw}));
}

class FwAttitudeTest : public ::testing::Test {
  protected:
    FwAttitudeTest() {
        params_.roll_time = params_.pitch_time = 0.4F;
        params_.roll_rate_limit = params_.pitch_rate_limit = params_.yaw_rate_limit = 10.0F;
        params_.trim_airspeed = 17.0F;
        params_.stall_airspeed = 10.0F;
        params_.stick_roll = 0.8F;
        params_.stick_pitch = 0.4F;
        params_.level_pitch = 0.05F;
        setpoint_.q_d = attitude_.q = euler(0.0F, 0.0F, 0.0F);
        setpoint_.thrust_body = {0.5F, 0.0F, 0.0F};
    }
    void step() {
        FwAttitudePorts ports{
            .attitude = Input(attitude_),
            .setpoint = has_setpoint_ ? Input(setpoint_) : Input<VehicleAttitudeSetpoint>(),
            .airspeed = Input(airspeed_),
            .sticks = Input(sticks_),
            .status = Input(status_),
            .params = Input(params_)};
        testing::Probe rates(ports.rates, 0);
        node_.step(ports);
        rates_ = rates.newest();
    }

    FwAttitude node_;
    VehicleAttitude attitude_{};
    VehicleAttitudeSetpoint setpoint_{};
    AirspeedValidated airspeed_{.true_airspeed_m_s = 17.0F};
    ManualControlSetpoint sticks_{};
    VehicleStatus status_{.nav_state = VehicleStatus::NavState::kMission};
    FwAttitudeParams params_{};
    VehicleRatesSetpoint rates_{};
    bool has_setpoint_ = true;
};

// A level turn at 45 deg and 17 m/s: 9.80665/17 = 0.5769 rad/s about the vertical, of which B's y
// and z axes get sin 45 and cos 45 = 0.4079.
TEST_F(FwAttitudeTest, ABankTurnsWithoutSideslip) {
    attitude_.q = setpoint_.q_d = euler(45.0F * kDegree, 0.0F, 1.0F);
    step();
    EXPECT_NEAR(rates_.roll, 0.0F, 1e-5F);
    EXPECT_NEAR(rates_.pitch, 0.4079F, 1e-3F);
    EXPECT_NEAR(rates_.yaw, 0.4079F, 1e-3F);
    EXPECT_EQ(rates_.thrust_body[0], 0.5F);
}

TEST_F(FwAttitudeTest, AnglesGoToTheirSetpointsInTheirTime) {
    setpoint_.q_d = euler(0.2F, 0.1F, 0.0F);
    step();
    EXPECT_NEAR(rates_.roll, 0.5F, 1e-4F);  // 0.2 rad in 0.4 s
    EXPECT_NEAR(rates_.pitch, 0.25F, 1e-4F);
    EXPECT_NEAR(rates_.yaw, 0.0F, 1e-4F);
}

TEST_F(FwAttitudeTest, TheHeadingOfTheSetpointDoesNotCount) {
    setpoint_.q_d = euler(0.0F, 0.0F, 2.0F);
    step();
    EXPECT_NEAR(rates_.yaw, 0.0F, 1e-4F);
}

TEST_F(FwAttitudeTest, OnTheGroundARateOfHeadingSteers) {
    setpoint_.yaw_sp_move_rate = 0.3F;
    step();
    EXPECT_NEAR(rates_.yaw, 0.3F, 1e-5F);
}

TEST_F(FwAttitudeTest, RatesAreLimited) {
    params_.roll_rate_limit = 1.0F;
    setpoint_.q_d = euler(1.0F, 0.0F, 0.0F);
    step();
    EXPECT_EQ(rates_.roll, 1.0F);
}

TEST_F(FwAttitudeTest, SticksAreTheSetpointByHand) {
    status_.nav_state = VehicleStatus::NavState::kStabilized;
    sticks_ = {.valid = true, .roll = 0.5F, .pitch = -0.5F, .throttle = 1.0F};
    step();
    EXPECT_NEAR(rates_.roll, 1.0F, 1e-4F);           // 0.8 rad * 0.5 / 0.4 s
    EXPECT_NEAR(rates_.pitch, 0.25F / 0.4F, 1e-4F);  // 0.05 + 0.4 * 0.5
    EXPECT_EQ(rates_.thrust_body[0], 1.0F);
}

TEST_F(FwAttitudeTest, WithoutSetpointItLevelsTheWings) {
    has_setpoint_ = false;
    attitude_.q = euler(0.2F, 0.0F, 0.0F);
    step();
    EXPECT_EQ(rates_.roll, 0.0F);  // none was ever there
    has_setpoint_ = true;
    step();
    setpoint_.q_d[0] = math::canonical_nan<float>();
    step();
    EXPECT_NEAR(rates_.roll, -0.5F, 1e-2F);
    EXPECT_EQ(rates_.thrust_body[0], 0.5F);
}

}  // namespace
}  // namespace stator::apps::fw_attitude
