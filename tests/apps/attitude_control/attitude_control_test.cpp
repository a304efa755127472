// Attitude control: tilt before heading, the shorter way round, limits, absent setpoints,
// convergence.
#include "attitude_control.hpp"

#include <gtest/gtest.h>

#include "stator/random.hpp"
#include "stator/testing.hpp"

namespace stator::apps::attitude_control {
namespace {

using math::Quaternion;
using math::Vector3;

Quaternion<float> euler(float roll, float pitch, float yaw) {
    return math::from_euler(math::EulerAngles<float>{roll, pitch, yaw});
}

class AttitudeControlTest : public ::testing::Test {
  protected:
    AttitudeControlTest() {
        params_.tilt_p = 7.0F;
        params_.yaw_p = 2.0F;
        params_.roll_rate_limit = params_.pitch_rate_limit = params_.yaw_rate_limit = 100.0F;
        setpoint_.thrust_body = {0.0F, 0.0F, -0.5F};
        set(Quaternion<float>::Identity());
    }
    void set(const Quaternion<float>& q) { setpoint_.q_d = math::to_array(q); }

    Vector3<float> rates_at(const Quaternion<float>& q_NB) {
        const VehicleAttitude attitude{
            .timestamp = 0, .timestamp_sample = 0, .q = math::to_array(q_NB)};
        AttitudeControlPorts ports{
            .attitude = Input(attitude),
            .navigation = has_navigation_ ? Input(navigation_) : Input<VehicleAttitude>(),
            .setpoint = has_setpoint_ ? Input(setpoint_) : Input<VehicleAttitudeSetpoint>(),
            .sticks = Input(sticks_),
            .offboard = has_offboard_ ? Input(offboard_) : Input<OffboardSetpoint>(),
            .status = Input(status_),
            .params = Input(params_)};
        testing::Probe rates(ports.rates, 0);
        node_.step(ports);
        newest_ = rates.newest();
        return {newest_.roll, newest_.pitch, newest_.yaw};
    }

    AttitudeControl node_;
    VehicleAttitudeSetpoint setpoint_{};
    AttitudeControlParams params_{};
    VehicleRatesSetpoint newest_{};
    ManualControlSetpoint sticks_{};
    VehicleStatus status_{.nav_state = VehicleStatus::NavState::kHold};
    VehicleAttitude navigation_{};
    OffboardSetpoint offboard_{};
    bool has_offboard_ = false;
    bool has_setpoint_ = true;
    bool has_navigation_ = false;
};

TEST_F(AttitudeControlTest, in_the_mode_offboard_takes_the_attitude_and_rates_that_are_sent) {
    has_offboard_ = true;
    offboard_.kind = OffboardSetpoint::Kind::kAttitude;
    offboard_.q_d = math::to_array(euler(0.3F, 0.0F, 0.0F));
    offboard_.thrust = 0.7F;
    EXPECT_EQ(rates_at(euler(0.0F, 0.0F, 0.0F)), Vector3<float>::Zero());  // in hold
    status_.nav_state = VehicleStatus::NavState::kOffboard;
    EXPECT_NEAR(rates_at(euler(0.0F, 0.0F, 0.0F)).x(), 7.0F * 2.0F * math::sin(0.15F), 1e-5F);
    EXPECT_EQ(newest_.thrust_body[2], -0.7F);
    params_.roll_rate_limit = 1.0F;
    offboard_.kind = OffboardSetpoint::Kind::kRates;
    offboard_.rates = {2.0F, -0.5F, 0.25F};
    offboard_.thrust = 0.4F;
    EXPECT_EQ(rates_at(euler(0.2F, 0.0F, 0.0F)), Vector3<float>(1.0F, -0.5F, 0.25F));
    EXPECT_EQ(newest_.thrust_body[2], -0.4F);
    // Once they are old: level, with the thrust that there was.
    has_offboard_ = false;
    has_setpoint_ = false;
    EXPECT_LT(rates_at(euler(0.2F, 0.0F, 0.0F)).x(), -0.9F);
    EXPECT_EQ(newest_.thrust_body[2], -0.4F);
}

TEST_F(AttitudeControlTest, wants_nothing_before_the_first_setpoint) {
    has_setpoint_ = false;
    EXPECT_EQ(rates_at(euler(0.3F, 0.2F, 0.1F)), Vector3<float>::Zero());
    EXPECT_EQ(newest_.thrust_body[2], 0.0F);
}

TEST_F(AttitudeControlTest, rests_at_the_setpoint_and_passes_the_thrust_on) {
    set(euler(0.3F, -0.2F, 2.0F));
    EXPECT_LT(math::norm(rates_at(euler(0.3F, -0.2F, 2.0F))), 1e-5F);
    EXPECT_EQ(newest_.thrust_body, setpoint_.thrust_body);
}

TEST_F(AttitudeControlTest, rates_are_gain_times_twice_the_sine_of_half_the_error) {
    EXPECT_NEAR(rates_at(euler(0.2F, 0.0F, 0.0F)).x(), -7.0F * 2.0F * math::sin(0.1F), 1e-5F);
    EXPECT_NEAR(rates_at(euler(0.0F, -0.2F, 0.0F)).y(), 7.0F * 2.0F * math::sin(0.1F), 1e-5F);
    EXPECT_NEAR(rates_at(euler(0.0F, 0.0F, 0.2F)).z(), -2.0F * 2.0F * math::sin(0.1F), 1e-5F);
}

TEST_F(AttitudeControlTest, both_signs_of_a_quaternion_are_the_same_attitude) {
    const Quaternion<float> q = euler(0.4F, -0.3F, 3.0F);
    const Vector3<float> rates = rates_at(q);
    EXPECT_LT(math::norm(rates_at(Quaternion<float>(-q.coeffs())) - rates), 1e-5F);
    set(Quaternion<float>(-1.0F, 0.0F, 0.0F, 0.0F));
    EXPECT_LT(math::norm(rates_at(q) - rates), 1e-5F);
}

// The point of the split: however wrong the heading, tilt is corrected as fast as without.
TEST_F(AttitudeControlTest, tilt_goes_before_heading) {
    for (const float yaw : {0.0F, 1.0F, 2.0F, 3.0F, -3.0F}) {
        const Vector3<float> rates = rates_at(euler(0.0F, 0.0F, yaw) * euler(0.5F, 0.0F, 0.0F));
        EXPECT_NEAR(rates.x(), -7.0F * 2.0F * math::sin(0.25F), 1e-4F) << yaw;
        EXPECT_NEAR(rates.y(), 0.0F, 1e-4F) << yaw;
    }
}

TEST_F(AttitudeControlTest, turns_the_shorter_way_to_a_heading) {
    set(euler(0.0F, 0.0F, 3.0F));
    EXPECT_LT(rates_at(euler(0.0F, 0.0F, -3.0F)).z(), 0.0F);
    EXPECT_GT(rates_at(euler(0.0F, 0.0F, 2.5F)).z(), 0.0F);
}

TEST_F(AttitudeControlTest, upside_down_it_rolls_back_whatever_the_heading) {
    const Vector3<float> rates = rates_at(Quaternion<float>(0.0F, 1.0F, 0.0F, 0.0F));
    EXPECT_FLOAT_EQ(math::abs(rates.x()), 14.0F);
    EXPECT_EQ(rates.z(), 0.0F);
}

TEST_F(AttitudeControlTest, rates_stay_within_their_limits) {
    params_.roll_rate_limit = 1.0F;
    params_.pitch_rate_limit = 2.0F;
    params_.yaw_rate_limit = 0.5F;
    const Vector3<float> rates = rates_at(euler(1.0F, 1.0F, 0.0F) * euler(0.0F, 0.0F, 2.0F));
    EXPECT_EQ(math::abs(rates.x()), 1.0F);
    EXPECT_EQ(math::abs(rates.y()), 2.0F);
    EXPECT_EQ(math::abs(rates.z()), 0.5F);
}

// Rolled by a quarter, the right wing points down: turning about down is turning about B's y.
TEST_F(AttitudeControlTest, heading_rate_is_about_the_local_down_axis) {
    const Quaternion<float> q = euler(math::kHalfPi<float>, 0.0F, 0.0F);
    set(q);
    setpoint_.yaw_sp_move_rate = 0.3F;
    EXPECT_LT(math::norm(rates_at(q) - Vector3<float>(0.0F, 0.3F, 0.0F)), 1e-5F);
}

TEST_F(AttitudeControlTest, without_its_setpoint_it_levels_at_the_last_thrust) {
    set(euler(0.5F, 0.0F, 0.0F));
    rates_at(euler(0.5F, 0.0F, 0.0F));
    has_setpoint_ = false;
    const Vector3<float> rates = rates_at(euler(0.5F, 0.0F, 0.0F));
    EXPECT_NEAR(rates.x(), -7.0F * 2.0F * math::sin(0.25F), 1e-4F);
    EXPECT_NEAR(rates.z(), 0.0F, 1e-5F);
    EXPECT_EQ(newest_.thrust_body[2], -0.5F);
}

TEST_F(AttitudeControlTest, a_setpoint_that_is_no_number_reads_as_absent) {
    rates_at(Quaternion<float>::Identity());
    setpoint_.q_d[2] = math::canonical_nan<float>();
    EXPECT_NEAR(rates_at(euler(0.2F, 0.0F, 0.0F)).x(), -1.4F, 0.01F);
}

TEST_F(AttitudeControlTest, converges_from_any_attitude_to_any_other) {
    params_.roll_rate_limit = params_.pitch_rate_limit = 3.8F;
    params_.yaw_rate_limit = 1.5F;
    math::Random random(1);
    for (int trial = 0; trial < 50; ++trial) {
        std::array<float, 8> word;
        for (float& w : word) w = random.gaussian_float();
        Quaternion<float> q =
            math::normalized(Quaternion<float>(word[0], word[1], word[2], word[3]));
        const Quaternion<float> wanted =
            math::normalized(Quaternion<float>(word[4], word[5], word[6], word[7]));
        set(wanted);
        for (int i = 0; i < 2000; ++i) q = math::integrate(q, rates_at(q), 0.004F);
        EXPECT_LT(math::norm(math::to_rotation_vector(q.conjugate() * wanted)), 1e-3F) << trial;
    }
}

TEST_F(AttitudeControlTest, the_better_attitude_is_used_while_it_is_there) {
    set(euler(0.3F, 0.0F, 0.0F));
    navigation_.q = setpoint_.q_d;
    has_navigation_ = true;
    EXPECT_LT(math::norm(rates_at(Quaternion<float>::Identity())), 1e-5F);
    has_navigation_ = false;
    EXPECT_GT(rates_at(Quaternion<float>::Identity()).x(), 1.0F);
}

// Right stick to the right rolls right, forward pitches down; in the middle the throttle hovers.
TEST_F(AttitudeControlTest, by_hand_the_sticks_are_the_attitude) {
    status_.nav_state = VehicleStatus::NavState::kStabilized;
    sticks_ = {.valid = true, .roll = 1.0F, .pitch = 0.5F, .yaw = -1.0F};
    const Quaternion<float> wanted = euler(params_.stick_tilt, -0.5F * params_.stick_tilt, 1.0F);
    const Vector3<float> rates = rates_at(wanted);
    EXPECT_NEAR(rates.x(), params_.stick_yaw_rate * -0.28F, 0.05F);  // of the turn, as it leans
    EXPECT_LT(rates.z(), -0.7F * params_.stick_yaw_rate);
    EXPECT_NEAR(newest_.thrust_body[2], -params_.stick_hover, 1e-6F);
}

TEST_F(AttitudeControlTest, the_throttle_goes_from_what_keeps_the_attitude_to_the_most) {
    status_.nav_state = VehicleStatus::NavState::kManual;
    sticks_ = {.valid = true, .throttle = -1.0F};
    rates_at(Quaternion<float>::Identity());
    EXPECT_NEAR(newest_.thrust_body[2], -params_.stick_least, 1e-6F);
    EXPECT_GE(params_.stick_least, 0.1F);
    sticks_.throttle = 1.0F;
    rates_at(Quaternion<float>::Identity());
    EXPECT_NEAR(newest_.thrust_body[2], -params_.stick_most, 1e-6F);
}

TEST_F(AttitudeControlTest, sticks_that_are_not_heard_or_not_asked_do_nothing) {
    set(euler(0.0F, 0.0F, 0.0F));
    sticks_ = {.valid = false, .roll = 1.0F};
    status_.nav_state = VehicleStatus::NavState::kStabilized;
    EXPECT_LT(math::norm(rates_at(Quaternion<float>::Identity())), 1e-5F);
    sticks_.valid = true;
    status_.nav_state = VehicleStatus::NavState::kHold;
    EXPECT_LT(math::norm(rates_at(Quaternion<float>::Identity())), 1e-5F);
}

// The setpoint is as from a node that wants no thrust, or nothing; 125 steps are 0.5 s at 250 Hz.
TEST_F(AttitudeControlTest, by_hand_the_thrust_stays_while_the_sticks_are_not_heard) {
    using Nav = VehicleStatus::NavState;
    const Quaternion<float> q_NB = euler(0.0F, 0.0F, 1.0F);
    status_.arming_state = VehicleStatus::ArmingState::kArmed;
    for (const float thrust : {0.0F, math::canonical_nan<float>()}) {
        for (const Nav mode : {Nav::kStabilized, Nav::kManual}) {
            setpoint_.thrust_body[2] = thrust;
            status_.nav_state = mode;
            sticks_ = {.valid = true, .roll = 0.5F, .yaw = 1.0F, .throttle = 0.2F};
            rates_at(q_NB);
            const std::array<float, 3> before = newest_.thrust_body;
            EXPECT_LT(before[2], -params_.stick_hover);
            sticks_ = {.valid = false, .throttle = -1.0F};
            for (int i = 0; i < 125; ++i) {
                EXPECT_LT(math::norm(rates_at(q_NB)), 1e-5F);
                EXPECT_EQ(newest_.thrust_body, before) << i;
            }
            EXPECT_LT(rates_at(euler(0.2F, 0.0F, 1.0F)).x(), -1.0F);  // level
        }
    }
}

TEST_F(AttitudeControlTest, the_next_mode_ends_the_thrust_that_stayed) {
    status_ = {.arming_state = VehicleStatus::ArmingState::kArmed,
               .nav_state = VehicleStatus::NavState::kStabilized};
    sticks_ = {.valid = true, .throttle = 1.0F};
    rates_at(Quaternion<float>::Identity());
    sticks_.valid = false;
    status_.nav_state = VehicleStatus::NavState::kReturn;
    rates_at(Quaternion<float>::Identity());
    EXPECT_EQ(newest_.thrust_body, setpoint_.thrust_body);
}

TEST_F(AttitudeControlTest, disarmed_by_hand_no_thrust_stays) {
    status_ = {.arming_state = VehicleStatus::ArmingState::kArmed,
               .nav_state = VehicleStatus::NavState::kStabilized};
    sticks_ = {.valid = true, .throttle = 1.0F};
    setpoint_.thrust_body = {};
    rates_at(Quaternion<float>::Identity());
    sticks_.valid = false;
    status_.arming_state = VehicleStatus::ArmingState::kDisarmed;
    rates_at(Quaternion<float>::Identity());
    EXPECT_EQ(newest_.thrust_body[2], 0.0F);
}

// Wanted is 0.5 along a thrust axis tilted by 0.6; the vehicle is at 0.3 yet: the vertical part of
// what it gets is that of what was wanted.
TEST_F(AttitudeControlTest, a_tilt_that_lags_does_not_cost_height) {
    set(euler(0.6F, 0.0F, 0.0F));
    rates_at(euler(0.3F, 0.0F, 0.0F));
    EXPECT_NEAR(newest_.thrust_body[2] * math::cos(0.3F), -0.5F * math::cos(0.6F), 1e-6F);
    set(euler(0.0F, 0.0F, 0.0F));
    rates_at(euler(1.2F, 0.0F, 0.0F));
    EXPECT_NEAR(newest_.thrust_body[2], -0.5F * 1.25F, 1e-6F);  // and no more than that
}

}  // namespace
}  // namespace stator::apps::attitude_control
