// Body-rate control of an aeroplane: gains by airspeed, integral, absent inputs, a closed loop.
#include "fw_rate.hpp"

#include <gtest/gtest.h>

#include "stator/testing.hpp"

namespace stator::apps::fw_rate {
namespace {

constexpr float kNaN = math::canonical_nan<float>();

constexpr FwRateParams without_gains() {
    return {.roll_p = 0.0F,
            .roll_i = 0.0F,
            .roll_ff = 0.0F,
            .pitch_p = 0.0F,
            .pitch_i = 0.0F,
            .pitch_ff = 0.0F,
            .yaw_p = 0.0F,
            .yaw_i = 0.0F,
            .yaw_ff = 0.0F,
            .integral_limit = 0.4F,
            .trim_airspeed = 17.0F,
            .stall_airspeed = 10.0F};
}

class FwRateTest : public ::testing::Test {
  protected:
    FwRateTest() {
        status_.arming_state = VehicleStatus::ArmingState::kArmed;
        setpoint_.thrust_body = {0.5F, 0.0F, 0.0F};
    }
    void fly_at(float airspeed) { airspeed_.calibrated_airspeed_m_s = airspeed; }
    void step(uint64_t dt_us = 4000) {
        now_us_ += dt_us;
        gyro_.timestamp_sample = now_us_;
        FwRatePorts ports{
            .now = now_us_,
            .gyro = Input(gyro_),
            .setpoint = has_setpoint_ ? Input(setpoint_) : Input<VehicleRatesSetpoint>(),
            .airspeed = Input(airspeed_),
            .status = Input(status_),
            .land = Input(land_),
            .params = Input(params_)};
        testing::Probe torque(ports.torque, now_us_);
        testing::Probe thrust(ports.thrust, now_us_);
        node_.step(ports);
        publications_ = torque.count();
        if (torque.count() == 0) return;
        torque_ = torque.newest().xyz;
        thrust_ = thrust.newest().xyz;
    }

    FwRate node_;
    SensorGyro gyro_{};
    VehicleRatesSetpoint setpoint_{};
    AirspeedValidated airspeed_{.calibrated_airspeed_m_s = 17.0F};
    VehicleStatus status_{};
    VehicleLandDetected land_{};
    FwRateParams params_ = without_gains();
    std::array<float, 3> torque_{};
    std::array<float, 3> thrust_{};
    uint32_t publications_ = 0;
    bool has_setpoint_ = true;
    uint64_t now_us_ = 0;
};

// A surface's torque grows with the square of the airspeed: (17/13)^2 = 1.710.
TEST_F(FwRateTest, GainsGrowWithTheInverseSquareOfTheAirspeed) {
    params_.roll_p = 0.1F;
    setpoint_.roll = 1.0F;
    step();
    EXPECT_NEAR(torque_[0], 0.1F, 1e-6F);
    fly_at(13.0F);
    step();
    EXPECT_NEAR(torque_[0], 0.1710F, 1e-4F);
}

// The steady rate that a deflection makes grows with the airspeed itself: 17/13 = 1.308.
TEST_F(FwRateTest, FeedForwardGrowsWithTheInverseOfTheAirspeed) {
    params_.pitch_ff = 0.2F;
    setpoint_.pitch = 1.0F;
    fly_at(13.0F);
    step();
    EXPECT_NEAR(torque_[1], 0.2615F, 1e-4F);
}

TEST_F(FwRateTest, AirspeedCountsFromStallAndAsTrimWhereUnknown) {
    params_.roll_p = 0.1F;
    setpoint_.roll = 1.0F;
    fly_at(0.0F);
    step();
    EXPECT_NEAR(torque_[0], 0.289F, 1e-4F);  // (17/10)^2
    fly_at(kNaN);
    step();
    EXPECT_NEAR(torque_[0], 0.1F, 1e-6F);
}

TEST_F(FwRateTest, IntegratesInTheAirOnly) {
    params_.roll_i = 1.0F;
    setpoint_.roll = 1.0F;
    for (int i = 0; i < 50; ++i) step();
    step();
    EXPECT_NEAR(torque_[0], 0.2F, 1e-5F);  // 50 steps of 4 ms
    fly_at(9.0F);                          // below stall: on the wheels, with the gains of stall
    for (int i = 0; i < 50; ++i) step();
    EXPECT_NEAR(torque_[0], 0.204F * 2.89F, 1e-4F);
    land_.landed = true;
    step();
    step();
    EXPECT_EQ(torque_[0], 0.0F);
}

TEST_F(FwRateTest, AtItsLimitItIntegratesOnlyWhatLeadsAway) {
    params_.roll_p = 1.0F;
    params_.roll_i = 1.0F;
    setpoint_.roll = 2.0F;
    for (int i = 0; i < 100; ++i) step();
    EXPECT_EQ(torque_[0], 1.0F);
    setpoint_.roll = 0.0F;
    step();
    EXPECT_EQ(torque_[0], 0.0F);
}

TEST_F(FwRateTest, WithoutSetpointItStopsTurningAndKeepsTheThrust) {
    params_.roll_p = 0.1F;
    setpoint_.roll = 1.0F;
    step();
    has_setpoint_ = false;
    gyro_.xyz = {0.5F, 0.0F, 0.0F};
    step();
    EXPECT_NEAR(torque_[0], -0.05F, 1e-6F);
    EXPECT_EQ(thrust_[0], 0.5F);
}

TEST_F(FwRateTest, AGyroSampleThatIsNotANumberPassesUnused) {
    gyro_.xyz[1] = kNaN;
    step();
    EXPECT_EQ(publications_, 0U);
}

// The Ultra Stick 25e about x: 70 rad/s^2 at full aileron and 17 m/s, roll mode at 16.1 1/s there;
// the first grows with the square of the airspeed, the second with the airspeed. With the
// interface's gains and a servo of 20 ms.
TEST_F(FwRateTest, RollRateSettlesAtAnyAirspeed) {
    for (const float airspeed : {12.0F, 17.0F, 22.0F}) {
        node_ = {};
        params_.roll_p = 0.08F;
        params_.roll_i = 0.3F;
        params_.roll_ff = 0.23F;
        fly_at(airspeed);
        setpoint_.roll = 1.0F;
        float rate = 0.0F;
        float deflection = 0.0F;
        float most = 0.0F;
        const float ratio = airspeed / 17.0F;
        for (int i = 0; i < 500; ++i) {
            gyro_.xyz = {rate, 0.0F, 0.0F};
            step();
            deflection += (torque_[0] - deflection) * (0.004F / 0.02F);
            rate += 0.004F * (70.0F * ratio * ratio * deflection - 16.1F * ratio * rate);
            most = math::max(most, rate);
        }
        EXPECT_NEAR(rate, 1.0F, 0.03F) << airspeed;
        EXPECT_LT(most, 1.2F) << airspeed;
    }
}

}  // namespace
}  // namespace stator::apps::fw_rate
