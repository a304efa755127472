// Rate control: gains, integral and its limits, derivative, and what it does without inputs.
#include "rate_control.hpp"

#include <gtest/gtest.h>

#include "stator/testing.hpp"

namespace stator::apps::rate_control {
namespace {

constexpr float kNaN = math::canonical_nan<float>();

// All gains zero: a test sets the ones that it is about.
constexpr RateControlParams without_gains() {
    return {.roll_p = 0.0F,
            .roll_i = 0.0F,
            .roll_d = 0.0F,
            .pitch_p = 0.0F,
            .pitch_i = 0.0F,
            .pitch_d = 0.0F,
            .yaw_p = 0.0F,
            .yaw_i = 0.0F,
            .yaw_d = 0.0F,
            .integral_limit = 0.3F,
            .derivative_cutoff = 50.0F,
            .integrate_from = 0.2F};
}

class RateControlTest : public ::testing::Test {
  protected:
    RateControlTest() {
        status_.arming_state = VehicleStatus::ArmingState::kArmed;
        setpoint_.thrust_body = {0.0F, 0.0F, -0.5F};
    }

    // One gyro sample `dt_us` after the one before; the outputs as they are then.
    void step(uint64_t dt_us = 1000) {
        now_us_ += dt_us;
        gyro_.timestamp_sample = now_us_;
        RateControlPorts ports{
            .now = now_us_,
            .gyro = Input(gyro_),
            .setpoint = has_setpoint_ ? Input(setpoint_) : Input<VehicleRatesSetpoint>(),
            .status = Input(status_),
            .params = Input(params_, is_first_)};
        is_first_ = false;
        testing::Probe torque(ports.torque, now_us_);
        testing::Probe thrust(ports.thrust, now_us_);
        node_.step(ports);
        publications_ = torque.count();
        if (torque.count() == 0) return;
        torque_ = torque.newest();
        thrust_ = thrust.newest();
    }
    void steps(int count, uint64_t dt_us = 1000) {
        for (int i = 0; i < count; ++i) step(dt_us);
    }

    RateControl node_;
    SensorGyro gyro_{};
    VehicleRatesSetpoint setpoint_{};
    VehicleStatus status_{};
    RateControlParams params_ = without_gains();
    VehicleTorqueSetpoint torque_{};
    VehicleThrustSetpoint thrust_{};
    uint32_t publications_ = 0;
    uint64_t now_us_ = 1'000'000;
    bool has_setpoint_ = true;
    bool is_first_ = true;
};

TEST_F(RateControlTest, wants_nothing_before_the_first_setpoint) {
    params_.roll_p = 1.0F;
    has_setpoint_ = false;
    step();
    EXPECT_EQ(torque_.xyz, (std::array{0.0F, 0.0F, 0.0F}));
    EXPECT_EQ(thrust_.xyz, (std::array{0.0F, 0.0F, 0.0F}));
}

TEST_F(RateControlTest, torque_is_gain_times_error_on_each_axis) {
    params_.roll_p = 0.1F;
    params_.pitch_p = 0.2F;
    params_.yaw_p = 0.4F;
    gyro_.xyz = {0.0F, 1.0F, 0.0F};
    setpoint_.roll = 2.0F;
    setpoint_.yaw = -1.0F;
    step();
    EXPECT_FLOAT_EQ(torque_.xyz[0], 0.2F);
    EXPECT_FLOAT_EQ(torque_.xyz[1], -0.2F);
    EXPECT_FLOAT_EQ(torque_.xyz[2], -0.4F);
}

TEST_F(RateControlTest, passes_thrust_and_the_time_of_the_gyro_sample_on) {
    step();
    EXPECT_EQ(thrust_.xyz, setpoint_.thrust_body);
    EXPECT_EQ(thrust_.timestamp_sample, gyro_.timestamp_sample);
    EXPECT_EQ(torque_.timestamp_sample, gyro_.timestamp_sample);
}

TEST_F(RateControlTest, a_lost_setpoint_reads_as_no_rotation_at_the_last_thrust) {
    params_.roll_p = 0.1F;
    setpoint_.roll = 5.0F;
    step();
    has_setpoint_ = false;
    gyro_.xyz = {1.0F, 0.0F, 0.0F};
    step();
    EXPECT_FLOAT_EQ(torque_.xyz[0], -0.1F);
    EXPECT_EQ(thrust_.xyz[2], -0.5F);
}

TEST_F(RateControlTest, integral_is_gain_times_error_times_time_up_to_its_limit) {
    params_.pitch_i = 0.1F;
    setpoint_.pitch = 1.0F;
    steps(1);
    steps(1000);
    // The first step has no step before it and counts as the longest, 20 ms.
    EXPECT_NEAR(torque_.xyz[1], 0.1F * 1.02F, 1e-3F);
    steps(3000);
    EXPECT_FLOAT_EQ(torque_.xyz[1], 0.3F);
}

TEST_F(RateControlTest, integrates_by_the_time_between_samples_not_by_their_count) {
    params_.pitch_i = 0.1F;
    setpoint_.pitch = 1.0F;
    steps(501, 2000);
    EXPECT_NEAR(torque_.xyz[1], 0.1F * 1.02F, 1e-3F);
}

TEST_F(RateControlTest, does_not_integrate_at_a_thrust_that_leaves_it_on_the_ground) {
    params_.roll_i = 1.0F;
    setpoint_.roll = 1.0F;
    setpoint_.thrust_body = {0.0F, 0.0F, -0.19F};
    steps(100);
    EXPECT_EQ(torque_.xyz[0], 0.0F);
}

TEST_F(RateControlTest, disarming_clears_the_integral) {
    params_.roll_i = 1.0F;
    setpoint_.roll = 1.0F;
    steps(100);
    EXPECT_GT(torque_.xyz[0], 0.09F);
    status_.arming_state = VehicleStatus::ArmingState::kDisarmed;
    step();
    EXPECT_EQ(torque_.xyz[0], 0.0F);
}

TEST_F(RateControlTest, an_axis_at_its_limit_does_not_wind_up) {
    params_.roll_p = 0.5F;
    params_.roll_i = 1.0F;
    setpoint_.roll = 4.0F;  // wants a torque of 2
    steps(1000);
    EXPECT_EQ(torque_.xyz[0], 1.0F);
    setpoint_.roll = -1.0F;
    step();
    EXPECT_FLOAT_EQ(torque_.xyz[0], -0.5F);
}

TEST_F(RateControlTest, a_gap_counts_as_the_longest_step) {
    params_.roll_i = 1.0F;
    step();
    setpoint_.roll = 1.0F;
    step(10'000'000);
    step(0);
    EXPECT_NEAR(torque_.xyz[0], 0.02F, 1e-6F);
}

TEST_F(RateControlTest, derivative_of_a_steady_acceleration_is_that_acceleration) {
    params_.roll_d = 0.01F;
    for (int i = 0; i < 200; ++i) {
        gyro_.xyz[0] += 10.0F * 1e-3F;
        step();
    }
    EXPECT_NEAR(torque_.xyz[0], -0.01F * 10.0F, 1e-4F);
}

TEST_F(RateControlTest, derivative_stands_uneven_sampling) {
    params_.roll_d = 0.01F;
    for (int i = 0; i < 400; ++i) {
        const uint64_t dt_us = i % 2 == 0 ? 500 : 3500;
        gyro_.xyz[0] += 10.0F * static_cast<float>(dt_us) * 1e-6F;
        step(dt_us);
    }
    EXPECT_NEAR(torque_.xyz[0], -0.01F * 10.0F, 1e-3F);
}

// A Butterworth low pass halves the power at its cutoff.
TEST_F(RateControlTest, derivative_is_low_passed_at_the_cutoff) {
    params_.roll_d = 0.01F;
    constexpr float kOmega = math::kTwoPi<float> * 50.0F;
    float most = 0.0F;
    for (int i = 0; i < 1000; ++i) {
        gyro_.xyz[0] = 0.1F * math::sin(kOmega * 1e-3F * static_cast<float>(i));
        step();
        if (i > 500) most = math::max(most, torque_.xyz[0]);
    }
    EXPECT_NEAR(most, 0.01F * 0.1F * kOmega / math::sqrt(2.0F), 0.003F);
}

TEST_F(RateControlTest, a_step_of_the_setpoint_does_not_kick_the_derivative) {
    params_.roll_p = 0.1F;
    params_.roll_d = 0.1F;
    steps(10);
    setpoint_.roll = 1.0F;
    step();
    EXPECT_FLOAT_EQ(torque_.xyz[0], 0.1F);
}

TEST_F(RateControlTest, starts_in_a_spin_without_a_kick) {
    params_.roll_d = 0.1F;
    gyro_.xyz = {10.0F, 0.0F, 0.0F};
    step();
    EXPECT_EQ(torque_.xyz[0], 0.0F);
}

TEST_F(RateControlTest, a_gyro_sample_that_is_no_number_passes_unused) {
    params_.roll_i = 1.0F;
    params_.roll_d = 0.1F;
    step();
    gyro_.xyz[1] = kNaN;
    step();
    EXPECT_EQ(publications_, 0U);
    gyro_.xyz[1] = 0.0F;
    step();
    EXPECT_TRUE(math::is_finite(torque_.xyz[0] + torque_.xyz[1] + torque_.xyz[2]));
}

TEST_F(RateControlTest, a_setpoint_that_is_no_number_reads_as_zero) {
    params_.roll_p = 1.0F;
    setpoint_.pitch = kNaN;
    setpoint_.roll = 1.0F;
    setpoint_.thrust_body[2] = kNaN;
    step();
    EXPECT_EQ(torque_.xyz[0], 0.0F);
    EXPECT_EQ(thrust_.xyz[2], 0.0F);
}

}  // namespace
}  // namespace stator::apps::rate_control
