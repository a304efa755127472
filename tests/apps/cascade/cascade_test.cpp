// The control cascade in closed loop around a rigid body: step responses, hover, a whole flight.
#include <gtest/gtest.h>

#include <string>

#include "flying_cascade.hpp"

namespace stator::testing {
namespace {

std::string name_of(const ::testing::TestParamInfo<Mismatch>& info) {
    return info.param.name;
}

constexpr double kDegree = math::kPi<double> / 180.0;

// A response as a part of its step, from the first 10 % to the last moment off by more than 5 %.
struct StepResponse {
    double rise_s = 0.0;
    double overshoot = 0.0;
    double settling_s = 0.0;
};

template <class Value>
StepResponse measure(FlyingCascade& flight, double seconds, Value part) {
    StepResponse response;
    const double start = flight.seconds();
    double at_10 = 0.0;
    while (flight.seconds() - start < seconds) {
        flight.step();
        const double now = flight.seconds() - start;
        const double value = part();
        if (at_10 == 0.0 && value > 0.1) at_10 = now;
        if (response.rise_s == 0.0 && value > 0.9) response.rise_s = now - at_10;
        response.overshoot = math::max(response.overshoot, value - 1.0);
        if (math::abs(value - 1.0) > 0.05) response.settling_s = now;
    }
    return response;
}

void want_attitude(FlyingCascade& flight, const math::EulerAngles<float>& angles) {
    const math::Quaternion<float> q = math::from_euler(angles);
    flight.control_position = false;
    flight.attitude_setpoint.q_d = math::to_array(q);
}

math::EulerAngles<double> attitude(const FlyingCascade& flight) {
    return math::to_euler(flight.body.state.q_NB);
}

// Bounds: rise under 0.25 s, overshoot under 10 %, settling under 0.6 s.
void expect_crisp(const StepResponse& response) {
    EXPECT_GT(response.rise_s, 0.0);
    EXPECT_LT(response.rise_s, 0.25);
    EXPECT_LT(response.overshoot, 0.10);
    EXPECT_LT(response.settling_s, 0.6);
}

class AttitudeStep : public ::testing::TestWithParam<Mismatch> {};

TEST_P(AttitudeStep, roll_by_30_degrees_is_crisp) {
    FlyingCascade flight(GetParam());
    flight.start_hovering(100.0);
    want_attitude(flight, {static_cast<float>(30.0 * kDegree), 0.0F, 0.0F});
    expect_crisp(measure(flight, 2.0, [&] { return attitude(flight).roll / (30.0 * kDegree); }));
}

TEST_P(AttitudeStep, pitch_by_30_degrees_is_crisp) {
    FlyingCascade flight(GetParam());
    flight.start_hovering(100.0);
    want_attitude(flight, {0.0F, static_cast<float>(30.0 * kDegree), 0.0F});
    expect_crisp(measure(flight, 2.0, [&] { return attitude(flight).pitch / (30.0 * kDegree); }));
}

TEST_P(AttitudeStep, a_large_turn_does_not_tilt) {
    FlyingCascade flight(GetParam());
    flight.start_hovering(100.0);
    want_attitude(flight, {0.0F, 0.0F, 2.5F});
    double most_tilt = 0.0;
    const StepResponse response = measure(flight, 5.0, [&] {
        most_tilt = math::max(most_tilt, math::tilt(flight.body.state.q_NB));
        return attitude(flight).yaw / 2.5;
    });
    EXPECT_LT(response.overshoot, 0.05);
    EXPECT_LT(response.settling_s, 3.5);
    EXPECT_LT(most_tilt, 2.0 * kDegree);
}

INSTANTIATE_TEST_SUITE_P(
    Vehicles, AttitudeStep,
    ::testing::Values(Mismatch{}, Mismatch{.name = "noisy", .gyro_noise = 0.01},
                      Mismatch{.name = "light_arms", .inertia = 0.8, .gyro_noise = 0.01},
                      Mismatch{.name = "heavy_arms", .inertia = 1.2, .gyro_noise = 0.01}),
    name_of);

TEST(PositionStep, by_a_metre_converges_on_each_axis) {
    for (int axis = 0; axis < 3; ++axis) {
        FlyingCascade flight({.gyro_noise = 0.01});
        flight.start_hovering(10.0);
        std::array<float, 3> goal{0.0F, 0.0F, -10.0F};
        goal[static_cast<unsigned>(axis)] -= 1.0F;
        const double start = flight.body.state.position_N[axis];
        flight.hold_position(goal);
        const StepResponse response =
            measure(flight, 10.0, [&] { return start - flight.body.state.position_N[axis]; });
        EXPECT_LT(response.overshoot, 0.10) << axis;
        EXPECT_LT(response.settling_s, 4.0) << axis;
        EXPECT_NEAR(flight.body.state.position_N[axis], start - 1.0, 0.01) << axis;
    }
}

struct FlightRecord {
    double worst_hold_m = 0.0;
    double worst_tilt = 0.0;
    double seconds = 0.0;
};

double setpoint_error(const FlyingCascade& flight) {
    const auto& p = flight.trajectory.position;
    const Vector wanted(static_cast<double>(p[0]), static_cast<double>(p[1]),
                        static_cast<double>(p[2]));
    return math::norm(Vector(wanted - flight.body.state.position_N));
}

// Until disarmed after having been armed, at most 120 s.
FlightRecord fly_sequence(FlyingCascade& flight) {
    using Arming = VehicleStatus::ArmingState;
    FlightRecord record;
    flight.run_sequence = true;
    flight.status.arming_state = Arming::kDisarmed;
    bool was_armed = false;
    while (flight.seconds() < 120.0) {
        flight.step();
        const bool armed = flight.status.arming_state == Arming::kArmed;
        if (was_armed && !armed) break;
        was_armed = armed;
        const bool holds = flight.status.nav_state == VehicleStatus::NavState::kHold;
        if (armed && holds) {
            record.worst_hold_m = math::max(record.worst_hold_m, setpoint_error(flight));
        }
        record.worst_tilt = math::max(record.worst_tilt, math::tilt(flight.body.state.q_NB));
    }
    record.seconds = flight.seconds();
    return record;
}

class WholeFlight : public ::testing::TestWithParam<Mismatch> {};

TEST_P(WholeFlight, takes_off_holds_lands_and_disarms) {
    FlyingCascade flight(GetParam());
    flight.sequence_params.north = 0.5F;
    flight.sequence_params.heading = 0.7F;
    const FlightRecord record = fly_sequence(flight);
    EXPECT_LT(record.seconds, 50.0);
    EXPECT_LT(record.worst_hold_m, 0.15);
    EXPECT_LT(record.worst_tilt, 8.0 * kDegree);
    EXPECT_TRUE(flight.body.is_on_ground());
    EXPECT_GT(flight.body.touchdown_speed(), 0.1);
    EXPECT_LT(flight.body.touchdown_speed(), 0.7);
    EXPECT_NEAR(flight.body.state.position_N.x(), 0.5, 0.05);
    EXPECT_NEAR(flight.body.state.position_N.y(), 0.0, 0.05);
    EXPECT_NEAR(math::heading(flight.body.state.q_NB), 0.7, 0.02);
    flight.step();
    for (unsigned i = 0; i < 12; ++i) EXPECT_TRUE(math::is_nan(flight.motors[i])) << i;
}

INSTANTIATE_TEST_SUITE_P(
    Vehicles, WholeFlight,
    ::testing::Values(
        Mismatch{}, Mismatch{.name = "noisy", .gyro_noise = 0.01},
        Mismatch{.name = "shaken_and_late", .gyro_noise = 0.14, .position_delay_us = 30'000},
        Mismatch{.name = "heavy", .mass = 1.15, .thrust = 0.9, .gyro_noise = 0.01},
        Mismatch{.name = "light", .mass = 0.85, .thrust = 1.1, .gyro_noise = 0.01},
        Mismatch{.name = "bent", .torque_B = {0.05, 0.05, 0.01}, .gyro_noise = 0.01}),
    name_of);

TEST(LostPosition, still_lands_and_disarms) {
    FlyingCascade flight({.gyro_noise = 0.01});
    flight.run_sequence = true;
    while (flight.seconds() < 20.0) flight.step();
    flight.position_is_valid = false;
    while (!flight.body.is_on_ground() && flight.seconds() < 60.0) flight.step();
    EXPECT_TRUE(flight.body.is_on_ground());
    EXPECT_LT(flight.body.touchdown_speed(), 2.0);
    while (flight.status.arming_state == VehicleStatus::ArmingState::kArmed &&
           flight.seconds() < 90.0) {
        flight.step();
    }
    EXPECT_LT(flight.seconds(), 60.0);
}

}  // namespace
}  // namespace stator::testing
