// Position control: from errors to a thrust vector, its limits, anti-windup, unknown axes, arming.
#include "position_control.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "stator/testing.hpp"

namespace stator::apps::position_control {
namespace {

using math::Quaternion;
using math::Vector3;

constexpr float kNaN = math::canonical_nan<float>();
constexpr float kGravity = 9.80665F;
constexpr float kHover = 0.5F;

// No integral, no derivative: a test sets the gains that it is about.
constexpr PositionControlParams proportional() {
    return {.horizontal_p = 1.0F,
            .horizontal_velocity_p = 2.0F,
            .horizontal_velocity_i = 0.0F,
            .horizontal_velocity_d = 0.0F,
            .vertical_p = 1.0F,
            .vertical_velocity_p = 4.0F,
            .vertical_velocity_i = 0.0F,
            .vertical_velocity_d = 0.0F,
            .derivative_cutoff = 5.0F,
            .integral_limit = 4.0F,
            .horizontal_speed_limit = 4.0F,
            .climb_limit = 2.0F,
            .descent_limit = 1.0F,
            .tilt_limit = 0.6F,
            .hover_thrust = kHover,
            .hover_time_constant = 2.0F,
            .drag = 0.0F,
            .thrust_min = 0.1F,
            .thrust_max = 0.9F,
            .spool_up_time = 0.1F,
            .blind_sink = 0.3F};
}

class PositionControlTest : public ::testing::Test {
  protected:
    PositionControlTest() {
        position_.xy_valid = position_.z_valid = position_.v_xy_valid = position_.v_z_valid = true;
        status_.arming_state = VehicleStatus::ArmingState::kArmed;
        status_.nav_state = VehicleStatus::NavState::kHold;
    }

    // Gives a new position 10 ms after the one before.
    void step() {
        now_us_ += 10'000;
        position_.timestamp_sample = now_us_;
        PositionControlPorts ports{
            .now = now_us_,
            .position = has_position_ ? Input(position_) : Input<VehicleLocalPosition>(),
            .setpoint = has_setpoint_ ? Input(setpoint_) : Input<TrajectorySetpoint>(),
            .status = Input(status_),
            .land = has_land_ ? Input(land_) : Input<VehicleLandDetected>(),
            .params = Input(params_, is_first_)};
        is_first_ = false;
        testing::Probe probe(ports.attitude_setpoint, now_us_);
        node_.step(ports);
        publications_ = probe.count();
        if (probe.count() != 0) newest_ = probe.newest();
    }
    void steps(int count) {
        for (int i = 0; i < count; ++i) step();
    }
    void spool_up() {
        steps(11);
        ASSERT_NEAR(thrust(), kHover, 1e-3F);
    }

    float thrust() const { return -newest_.thrust_body[2]; }
    Quaternion<float> attitude() const { return math::quaternion(newest_.q_d); }
    // Acceleration that the wanted thrust gives a vehicle whose hover thrust is as the parameter
    // says.
    Vector3<float> acceleration() const {
        const Vector3<float> thrust_B(0.0F, 0.0F, -thrust());
        const Vector3<float> thrust_N = attitude().toRotationMatrix() * thrust_B;
        return thrust_N * (kGravity / kHover) + Vector3<float>(0.0F, 0.0F, kGravity);
    }

    PositionControl node_;
    VehicleLocalPosition position_{};
    TrajectorySetpoint setpoint_{};
    VehicleStatus status_{};
    PositionControlParams params_ = proportional();
    VehicleAttitudeSetpoint newest_{};
    uint32_t publications_ = 0;
    uint64_t now_us_ = 1'000'000;
    bool has_position_ = true;
    bool has_land_ = false;
    VehicleLandDetected land_{};
    bool has_setpoint_ = true;
    bool is_first_ = true;
};

TEST_F(PositionControlTest, disarmed_it_wants_level_and_no_thrust) {
    status_.arming_state = VehicleStatus::ArmingState::kDisarmed;
    position_.heading = 1.0F;
    setpoint_.position = {5.0F, 0.0F, -5.0F};
    step();
    EXPECT_EQ(thrust(), 0.0F);
    EXPECT_LT(math::tilt(attitude()), 1e-4F);
    EXPECT_NEAR(math::heading(attitude()), 1.0F, 1e-5F);
}

TEST_F(PositionControlTest, thrust_rises_from_nothing_after_arming) {
    params_.spool_up_time = 1.0F;
    setpoint_.position = {0.0F, 0.0F, -10.0F};
    step();
    float before = thrust();
    EXPECT_LT(before, 0.1F);
    for (int i = 0; i < 80; ++i) {
        step();
        EXPECT_LT(thrust() - before, 0.01F);
        before = thrust();
    }
    EXPECT_GT(thrust(), 0.7F);
}

TEST_F(PositionControlTest, at_the_setpoint_it_hovers_level_at_the_wanted_heading) {
    setpoint_.yaw = -2.0F;
    spool_up();
    EXPECT_LT(math::tilt(attitude()), 1e-4F);
    EXPECT_NEAR(math::heading(attitude()), -2.0F, 1e-5F);
}

// p * p_velocity * error: 1 * 2 * 0.5 north, 1 * 4 * 0.2 up.
TEST_F(PositionControlTest, accelerates_towards_the_setpoint) {
    spool_up();
    setpoint_.position = {0.5F, -0.5F, -0.2F};
    step();
    EXPECT_LT(math::norm(acceleration() - Vector3<float>(1.0F, -1.0F, -0.8F)), 1e-3F);
}

TEST_F(PositionControlTest, velocity_and_acceleration_are_fed_forward) {
    spool_up();
    setpoint_.velocity = {0.5F, 0.0F, 0.0F};
    setpoint_.acceleration = {0.0F, 0.3F, -0.2F};
    step();
    EXPECT_LT(math::norm(acceleration() - Vector3<float>(1.0F, 0.3F, -0.2F)), 1e-3F);
}

TEST_F(PositionControlTest, thrust_points_where_it_should_at_any_heading) {
    spool_up();
    setpoint_.position = {0.5F, 0.0F, 0.0F};
    for (const float yaw : {-3.0F, -1.0F, 1.0F, 3.0F}) {
        setpoint_.yaw = yaw;
        step();
        EXPECT_NEAR(acceleration().x(), 1.0F, 1e-3F) << yaw;
        EXPECT_NEAR(acceleration().y(), 0.0F, 1e-3F) << yaw;
    }
}

TEST_F(PositionControlTest, far_away_it_flies_at_the_speed_limit) {
    spool_up();
    setpoint_.position = {300.0F, 400.0F, -50.0F};
    position_.vx = 2.4F;
    position_.vy = 3.2F;
    position_.vz = -2.0F;
    step();
    EXPECT_LT(math::norm(acceleration()), 1e-2F);
}

TEST_F(PositionControlTest, tilt_is_limited_and_the_weight_still_carried) {
    params_.horizontal_velocity_p = 10.0F;
    spool_up();
    setpoint_.position = {100.0F, 0.0F, 0.0F};
    step();
    EXPECT_NEAR(math::tilt(attitude()), 0.6F, 1e-4F);
    EXPECT_NEAR(acceleration().z(), 0.0F, 1e-3F);
}

// Which leaves a margin to steer with.
TEST_F(PositionControlTest, height_goes_before_direction_at_full_thrust) {
    params_.horizontal_velocity_p = 10.0F;
    params_.vertical_velocity_p = 15.0F;
    spool_up();
    setpoint_.position = {100.0F, 0.0F, -100.0F};
    step();
    EXPECT_NEAR(thrust(), 0.9F, 1e-4F);
    EXPECT_NEAR(math::tilt(attitude()), std::asin(params_.lean_margin), 1e-3F);
    setpoint_.position[0] = 0.0F;
    step();
    EXPECT_NEAR(thrust(), 0.9F, 1e-4F);
    EXPECT_LT(math::tilt(attitude()), 1e-2F);
}

TEST_F(PositionControlTest, some_thrust_stays_in_the_fastest_descent) {
    params_.vertical_velocity_p = 15.0F;
    spool_up();
    setpoint_.position = {0.0F, 0.0F, 100.0F};
    step();
    EXPECT_FLOAT_EQ(thrust(), 0.1F);
}

TEST_F(PositionControlTest, integral_grows_with_time_to_its_limit) {
    params_.vertical_velocity_i = 1.0F;
    spool_up();
    position_.vz = 0.1F;
    steps(100);
    EXPECT_NEAR(acceleration().z(), -(0.4F + 0.1F), 2e-3F);
    params_.integral_limit = 0.2F;
    is_first_ = true;
    steps(300);
    EXPECT_NEAR(acceleration().z(), -(0.4F + 0.2F), 2e-3F);
}

TEST_F(PositionControlTest, a_saturated_axis_does_not_wind_up) {
    params_.vertical_velocity_i = 1.0F;
    params_.horizontal_velocity_i = 1.0F;
    spool_up();
    setpoint_.position = {100.0F, 0.0F, 100.0F};
    params_.horizontal_velocity_p = 10.0F;
    params_.vertical_velocity_p = 15.0F;
    is_first_ = true;
    steps(500);
    setpoint_.position = {};
    step();
    EXPECT_LT(math::norm(acceleration()), 1e-2F);
}

TEST_F(PositionControlTest, disarming_clears_the_integral_and_the_spool_up) {
    params_.vertical_velocity_i = 1.0F;
    spool_up();
    position_.vz = 0.5F;
    steps(100);
    position_.vz = 0.0F;
    status_.arming_state = VehicleStatus::ArmingState::kDisarmed;
    step();
    status_.arming_state = VehicleStatus::ArmingState::kArmed;
    step();
    EXPECT_LT(thrust(), 0.1F);
    spool_up();
}

TEST_F(PositionControlTest, derivative_opposes_measured_acceleration) {
    params_.horizontal_velocity_d = 0.5F;
    spool_up();
    setpoint_.position[0] = setpoint_.velocity[0] = kNaN;
    for (int i = 0; i < 100; ++i) {
        position_.vx += 2.0F * 0.01F;
        step();
    }
    EXPECT_NEAR(acceleration().x(), -0.5F * 2.0F, 0.02F);
}

TEST_F(PositionControlTest, a_free_axis_is_left_alone) {
    spool_up();
    setpoint_.position = {kNaN, kNaN, 0.0F};
    setpoint_.velocity = {kNaN, 0.0F, 0.0F};
    position_.vx = 1.0F;
    position_.vy = 1.0F;
    step();
    EXPECT_NEAR(acceleration().x(), 0.0F, 1e-4F);
    EXPECT_NEAR(acceleration().y(), -2.0F, 1e-3F);
}

TEST_F(PositionControlTest, a_free_heading_stays_where_it_is) {
    setpoint_.yaw = kNaN;
    position_.heading = 2.0F;
    step();
    EXPECT_NEAR(math::heading(attitude()), 2.0F, 1e-5F);
}

TEST_F(PositionControlTest, without_a_setpoint_it_stands_still) {
    spool_up();
    has_setpoint_ = false;
    position_.x = 100.0F;
    position_.vx = 0.5F;
    step();
    EXPECT_LT(math::norm(acceleration() - Vector3<float>(-1.0F, 0.0F, 0.0F)), 1e-3F);
}

TEST_F(PositionControlTest, with_an_unknown_horizontal_velocity_it_flies_level) {
    spool_up();
    setpoint_.position = {10.0F, 0.0F, 0.0F};
    position_.xy_valid = position_.v_xy_valid = false;
    step();
    EXPECT_LT(math::tilt(attitude()), 1e-4F);
    EXPECT_NEAR(acceleration().z(), 0.0F, 1e-3F);
}

TEST_F(PositionControlTest, with_an_unknown_vertical_velocity_it_sinks_gently) {
    spool_up();
    setpoint_.position = {0.0F, 0.0F, -10.0F};
    position_.v_z_valid = false;
    step();
    EXPECT_NEAR(acceleration().z(), 0.3F, 1e-3F);
}

// 25 % too much thrust was learned from a wrong velocity: the height alone shows the climb.
TEST_F(PositionControlTest, with_an_unknown_vertical_velocity_it_does_not_rise_for_long) {
    spool_up();
    position_.v_z_valid = false;
    float climb = 0.0F;
    for (int i = 0; i < 3000; ++i) {
        climb += kGravity * (thrust() / (0.8F * kHover) - 1.0F) * 0.01F;
        position_.z -= climb * 0.01F;
        step();
    }
    EXPECT_LT(climb, 0.1F);
    EXPECT_GT(climb, -2.0F);
    // A reset of the height does not count as motion.
    const float before = thrust();
    position_.z -= 30.0F;
    ++position_.z_reset_counter;
    step();
    EXPECT_NEAR(thrust(), before, 0.01F);
}

TEST_F(PositionControlTest, with_an_unknown_position_it_holds_the_velocity) {
    spool_up();
    setpoint_.position = {10.0F, 0.0F, 0.0F};
    position_.xy_valid = false;
    position_.vx = 0.5F;
    step();
    EXPECT_NEAR(acceleration().x(), -1.0F, 1e-3F);
}

TEST_F(PositionControlTest, a_missing_position_is_awaited_then_it_sinks_level) {
    spool_up();
    setpoint_.position = {10.0F, 0.0F, 0.0F};
    has_position_ = false;
    step();
    EXPECT_EQ(publications_, 0U);
    steps(40);
    EXPECT_EQ(publications_, 1U);
    EXPECT_LT(math::tilt(attitude()), 1e-4F);
    EXPECT_NEAR(acceleration().z(), 0.3F, 1e-3F);
}

TEST_F(PositionControlTest, drag_is_fed_forward_with_the_wanted_velocity) {
    params_.drag = 0.3F;
    spool_up();
    setpoint_.velocity = {2.0F, 0.0F, 0.0F};
    position_.vx = 2.0F;
    step();
    EXPECT_NEAR(acceleration().x(), 0.6F, 1e-3F);
}

TEST_F(PositionControlTest, on_the_ground_it_wants_nothing_until_it_shall_climb) {
    has_land_ = true;
    land_.landed = true;
    setpoint_.position = {5.0F, 0.0F, 0.0F};
    steps(20);
    EXPECT_EQ(thrust(), params_.thrust_min);
    EXPECT_LT(math::tilt(attitude()), 1e-4F);
    setpoint_.velocity[2] = -0.5F;
    step();
    EXPECT_LT(thrust(), 0.2F);  // spools up
    steps(20);
    EXPECT_GT(thrust(), kHover);
}

// Not even no thrust, which would cut the motors whenever the sticks are not heard.
TEST_F(PositionControlTest, by_hand_it_wants_nothing) {
    spool_up();
    for (const auto mode :
         {VehicleStatus::NavState::kStabilized, VehicleStatus::NavState::kManual}) {
        status_.nav_state = mode;
        step();
        EXPECT_TRUE(math::is_nan(thrust()));
        EXPECT_TRUE(math::is_nan(newest_.q_d[0]));
    }
    status_.arming_state = VehicleStatus::ArmingState::kDisarmed;
    step();
    EXPECT_EQ(thrust(), 0.0F);
    status_.arming_state = VehicleStatus::ArmingState::kArmed;
    status_.nav_state = VehicleStatus::NavState::kHold;
    steps(11);
    EXPECT_NEAR(thrust(), kHover, 1e-3F);
}

// A vehicle 20 % heavier than the parameter says: v' = g (1 - thrust / 0.6). The learned thrust
// carries it, so that what is left to the integral fades.
TEST_F(PositionControlTest, in_flight_it_learns_the_thrust_that_carries_the_weight) {
    has_land_ = true;
    params_.vertical_velocity_i = 2.0F;
    setpoint_.velocity = {0.0F, 0.0F, 0.0F};
    setpoint_.position = {kNaN, kNaN, kNaN};
    for (int i = 0; i < 2000; ++i) {
        step();
        position_.vz += kGravity * (1.0F - thrust() / 0.6F) * 0.01F;
    }
    EXPECT_NEAR(position_.vz, 0.0F, 1e-3F);
    EXPECT_NEAR(thrust(), 0.6F, 1e-3F);
    // Of 1 m/s^2 upwards, the vehicle gets what it is told only if its hover thrust is known.
    setpoint_.acceleration[2] = -1.0F;
    step();
    EXPECT_NEAR(kGravity * (1.0F - thrust() / 0.6F), -1.0F, 0.02F);
}

}  // namespace
}  // namespace stator::apps::position_control
