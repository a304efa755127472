// The simulated quadrotor against analytic mechanics.
#include "world/plant.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "iris.hpp"

namespace stator::world {
namespace {

constexpr float kStopped = std::numeric_limits<float>::quiet_NaN();
constexpr double kGravity = 9.80665;

Airframe without_drag() {
    Airframe parameters = iris().airframe;
    parameters.rotor_drag = 0.0;
    parameters.drag_area_B.setZero();
    return parameters;
}

VehicleState in_the_air() {
    VehicleState state;
    state.position_N = Vector3(1.0, 2.0, -1000.0);
    return state;
}

void run(Plant& plant, double seconds, double dt = 1e-3) {
    const int steps = static_cast<int>(std::lround(seconds / dt));
    for (int i = 0; i < steps; ++i) plant.step(dt);
}

// sqrt(m g / (4 k_T)) = sqrt(1.535 * 9.80665 / (4 * 5.84e-6)), with a calculator.
constexpr double kHoverSpeed = 802.746;

float hover_control() {
    return static_cast<float>(std::pow(kHoverSpeed / 1100.0, 2));
}

TEST(Plant, falls_freely) {
    Plant plant(without_drag(), in_the_air());
    run(plant, 2.0);
    EXPECT_NEAR(plant.state().position_N.z(), -1000.0 + 0.5 * kGravity * 4.0, 1e-9);
    EXPECT_NEAR(plant.state().velocity_N.z(), kGravity * 2.0, 1e-9);
    EXPECT_NEAR(plant.specific_force_B().norm(), 0.0, 1e-12);
}

TEST(Plant, keeps_energy_and_angular_momentum_without_torque) {
    Airframe parameters = without_drag();
    parameters.inertia = {.xx = 0.02, .yy = 0.03, .zz = 0.055};  // tumbles about the middle axis
    VehicleState state = in_the_air();
    state.rate_B = Vector3(0.1, 7.0, 0.2);
    const auto energy = [&](const VehicleState& at) {
        return 0.5 * at.rate_B.dot(parameters.inertia.times(at.rate_B));
    };
    const auto momentum_N = [&](const VehicleState& at) {
        return Vector3(at.q_NB * parameters.inertia.times(at.rate_B));
    };
    Plant plant(parameters, state);
    run(plant, 10.0);
    // Ten thousand steps that are each wrong by about (7 rad/s * 1 ms)^5 / 120 = 1.4e-13.
    EXPECT_NEAR(energy(plant.state()) / energy(state), 1.0, 1e-8);
    EXPECT_NEAR((momentum_N(plant.state()) - momentum_N(state)).norm(), 0.0,
                1e-8 * momentum_N(state).norm());
    EXPECT_LT(plant.state().rate_B.y(), 7.0 - 1e-3);  // it has tumbled, else this tells nothing
}

TEST(Plant, nutates_as_a_symmetric_top) {
    VehicleState state = in_the_air();
    state.rate_B = Vector3(2.0, 0.0, 5.0);
    Plant plant(without_drag(), state);
    run(plant, 3.0);
    // Euler's equations for Ix = Iy: the rate's cross part turns with (Iz - Ix) / Ix * rate_z.
    const double phase = (0.055225 - 0.029125) / 0.029125 * 5.0 * 3.0;
    EXPECT_NEAR(plant.state().rate_B.x(), 2.0 * std::cos(phase), 1e-9);
    EXPECT_NEAR(plant.state().rate_B.y(), 2.0 * std::sin(phase), 1e-9);
    EXPECT_NEAR(plant.state().rate_B.z(), 5.0, 1e-12);
}

TEST(Plant, hovers_at_the_speed_that_carries_its_weight) {
    VehicleState state = in_the_air();
    state.rotor_speeds.setConstant(kHoverSpeed);
    Plant plant(iris().airframe, state);
    plant.command({hover_control(), hover_control(), hover_control(), hover_control()});
    run(plant, 1.0);
    // As published for this vehicle: 803 rad/s.
    EXPECT_NEAR(plant.state().rotor_speeds[0], 803.0, 0.5);
    const double sink_speed = plant.state().velocity_N.z();
    run(plant, 1.0);
    // A float's rounding of the command and six digits of speed leave less than 1e-4 m/s^2.
    EXPECT_NEAR(plant.state().velocity_N.z() - sink_speed, 0.0, 1e-2 * sink_speed + 1e-4);
    EXPECT_NEAR(plant.specific_force_B().z(), -kGravity, 5e-3);
    EXPECT_EQ(plant.state().rate_B, Vector3::Zero());
}

TEST(Plant, reaches_terminal_velocity) {
    VehicleState state = in_the_air();
    state.position_N.z() = -5000.0;
    Plant plant(iris().airframe, state);
    // m v' = m g - 1/2 rho A v^2 from rest: v = u tanh(g t / u), u = sqrt(2 m g / (rho A)).
    const double terminal = std::sqrt(2.0 * 1.535 * kGravity / (1.225 * 0.05));
    run(plant, 2.0);
    EXPECT_NEAR(plant.state().velocity_N.z(), terminal * std::tanh(kGravity * 2.0 / terminal),
                1e-9);
    run(plant, 28.0);
    EXPECT_NEAR(plant.state().velocity_N.z(), terminal, 1e-6);
}

TEST(Plant, rotors_brake_sideways_motion) {
    Airframe parameters = without_drag();
    parameters.rotor_drag = 1.75e-4;
    VehicleState state = in_the_air();
    state.velocity_N = Vector3(3.0, -2.0, 0.0);
    state.rotor_speeds.setConstant(kHoverSpeed);
    Plant plant(parameters, state);
    plant.command({hover_control(), hover_control(), hover_control(), hover_control()});
    run(plant, 1.0);
    // m v' = -4 k speed v.
    const double left = std::exp(-4.0 * 1.75e-4 * kHoverSpeed / 1.535);
    EXPECT_NEAR(plant.state().velocity_N.x(), 3.0 * left, 1e-5);
    EXPECT_NEAR(plant.state().velocity_N.y(), -2.0 * left, 1e-5);
}

TEST(Plant, rotors_brake_yaw) {
    Airframe parameters = without_drag();
    parameters.rotor_drag = 1.75e-4;
    VehicleState state = in_the_air();
    state.rate_B.z() = 2.0;
    state.rotor_speeds.setConstant(kHoverSpeed);
    Plant plant(parameters, state);
    plant.command({hover_control(), hover_control(), hover_control(), hover_control()});
    run(plant, 1.0);
    // Izz rate' = -k speed rate times the sum of the arms squared, two of each length.
    const double arms2 = 2.0 * (0.13 * 0.13 + 0.22 * 0.22) + 2.0 * (0.13 * 0.13 + 0.20 * 0.20);
    const double left = std::exp(-1.75e-4 * kHoverSpeed * arms2 / 0.055225);
    EXPECT_NEAR(plant.state().rate_B.z(), 2.0 * left, 1e-5);
}

TEST(Plant, climbing_takes_thrust_from_the_rotors) {
    VehicleState state = in_the_air();
    state.velocity_N.z() = -3.0;
    state.rotor_speeds.setConstant(kHoverSpeed);
    Plant plant(without_drag(), state);
    plant.command({hover_control(), hover_control(), hover_control(), hover_control()});
    run(plant, 1.0);
    // m v' = -4 k_T speed v / pitch, so that it ends where it hovers.
    const double left = std::exp(-4.0 * 5.84e-6 * kHoverSpeed / 0.03114 / 1.535);
    EXPECT_NEAR(plant.state().velocity_N.z(), -3.0 * left, 1e-4);
}

// Without drag, so that nothing but the wind at the rotors acts.
TEST(Plant, wind_turns_a_rotor_over) {
    Airframe parameters = without_drag();
    parameters.inflow_pitch = 1e9;
    VehicleState state = in_the_air();
    state.rotor_speeds[0] = 800.0;
    parameters.rotors[0].place_B = Vector3::Zero();
    parameters.fall_time_constant = 1e9;
    Plant plant(parameters, state);
    plant.set_influence({.wind_N = Vector3(-10.0, 0.0, 0.0)});
    run(plant, 0.001);
    // Seen from above it turns left, so the right blade meets the wind, and lifts: rolls left.
    EXPECT_NEAR(plant.state().rate_B.x(), -1e-6 * 800.0 * 10.0 / 0.029125 * 0.001, 1e-9);
}

TEST(Plant, is_carried_along_by_the_wind) {
    VehicleState state = in_the_air();
    state.velocity_N = Vector3(4.0, -3.0, 0.0);
    state.rotor_speeds.setConstant(kHoverSpeed);
    Plant plant(iris().airframe, state);
    plant.set_influence({.wind_N = Vector3(4.0, -3.0, 0.0)});
    plant.command({hover_control(), hover_control(), hover_control(), hover_control()});
    run(plant, 2.0);
    EXPECT_NEAR((plant.state().velocity_N - Vector3(4.0, -3.0, 0.0)).norm(), 0.0, 1e-3);
    EXPECT_NEAR(plant.velocity_in_air_B().norm(), 0.0, 1e-3);
}

TEST(Plant, low_voltage_turns_rotors_slower_and_a_broken_one_lifts_less) {
    Plant plant(iris().airframe, in_the_air());
    plant.set_influence({.supply = 0.9});
    plant.command({1.0F, 1.0F, 1.0F, 1.0F});
    run(plant, 1.0);
    EXPECT_NEAR(plant.state().rotor_speeds[3], 0.9 * 1100.0, 1e-6);
    VehicleState state = in_the_air();
    state.rotor_speeds.setConstant(kHoverSpeed);
    Plant broken(without_drag(), state);
    broken.set_influence({.efficiency = RotorSpeeds::Constant(0.5)});
    EXPECT_NEAR(broken.specific_force_B().z(), -0.5 * kGravity, 1e-4);
}

TEST(Plant, draws_the_power_of_momentum_theory) {
    VehicleState state = in_the_air();
    state.rotor_speeds.setConstant(kHoverSpeed);
    const Plant plant(iris().airframe, state);
    // T^1.5 / sqrt(2 rho A), twice, for 3.7634 N on 0.0507 m^2, four times, and 5 W: by calculator.
    EXPECT_NEAR(plant.electric_power(), 170.7, 0.1);
    EXPECT_NEAR(plant.lift_over_weight(), 1.0, 1e-5);
}

TEST(Plant, motors_lag_by_their_time_constants) {
    Plant plant(iris().airframe, in_the_air());
    plant.command({1.0F, 0.25F, 0.0F, kStopped});
    run(plant, 0.0125, 0.5e-3);
    const double risen = 1.0 - std::exp(-1.0);
    EXPECT_NEAR(plant.state().rotor_speeds[0], 1100.0 * risen, 1e-3);
    EXPECT_NEAR(plant.state().rotor_speeds[1], 550.0 * risen, 1e-3);
    EXPECT_EQ(plant.state().rotor_speeds[2], 0.0);
    EXPECT_EQ(plant.state().rotor_speeds[3], 0.0);
    plant.command({kStopped, kStopped, kStopped, kStopped});
    run(plant, 0.025);
    EXPECT_NEAR(plant.state().rotor_speeds[0], 1100.0 * risen * std::exp(-1.0), 1e-3);
}

TEST(Plant, commands_beyond_the_most_thrust_are_clamped) {
    Plant plant(iris().airframe, in_the_air());
    plant.command({7.0F, -1.0F, std::numeric_limits<float>::infinity(), 1.0F});
    run(plant, 1.0);
    EXPECT_NEAR(plant.state().rotor_speeds[0], 1100.0, 1e-6);
    EXPECT_EQ(plant.state().rotor_speeds[1], 0.0);
    EXPECT_NEAR(plant.state().rotor_speeds[2], 1100.0, 1e-6);
}

// Rotors 0 to 3: front right, rear left, front left, rear right; 0 and 1 counter-clockwise.
Vector3 rate_after(const Controls& control) {
    Plant plant(iris().airframe, in_the_air());
    plant.command(control);
    run(plant, 0.02);
    return plant.state().rate_B;
}

TEST(Plant, turns_the_way_each_rotor_pushes) {
    EXPECT_GT(rate_after({0.0F, 0.5F, 0.5F, 0.0F}).x(), 0.1) << "left side up: rolls right";
    EXPECT_GT(rate_after({0.5F, 0.0F, 0.5F, 0.0F}).y(), 0.1) << "front up: pitches up";
    EXPECT_GT(rate_after({0.5F, 0.5F, 0.0F, 0.0F}).z(), 0.01) << "counter-clockwise: yaws right";
    // 2 k_T speed^2 k_M / Izz, one time constant of 1 ms after a full step.
    VehicleState state = in_the_air();
    state.rotor_speeds.head<2>().setConstant(800.0);
    Airframe parameters = without_drag();
    parameters.fall_time_constant = 1e9;
    Plant plant(parameters, state);
    run(plant, 0.001);
    const double torque = 2.0 * 5.84e-6 * 800.0 * 800.0 * 0.06;
    EXPECT_NEAR(plant.state().rate_B.z(), torque / 0.055225 * 0.001, 1e-6);
}

TEST(Plant, error_falls_with_the_fourth_power_of_the_step) {
    const auto end = [](double dt) {
        VehicleState state = in_the_air();
        state.velocity_N = Vector3(5.0, 3.0, -2.0);
        state.rate_B = Vector3(2.0, -3.0, 4.0);
        state.rotor_speeds.head<4>() << 700.0, 750.0, 800.0, 850.0;
        Plant plant(iris().airframe, state);
        plant.command({0.9F, 0.92F, 0.94F, 0.96F});  // all speed up: no change of time constant
        run(plant, 0.32, dt);
        return plant.state();
    };
    const VehicleState exact = end(0.25e-3);
    const auto error = [&](double dt) {
        const VehicleState state = end(dt);
        return (state.position_N - exact.position_N).norm() +
               (state.q_NB.coeffs() - exact.q_NB.coeffs()).norm();
    };
    const double order = std::log2(error(4e-3) / error(2e-3));
    EXPECT_NEAR(order, 4.0, 0.3);
}

TEST(Ground, carries_a_vehicle_at_rest_without_drift) {
    Plant plant(iris().airframe, VehicleState{});
    run(plant, 30.0);
    EXPECT_TRUE(plant.is_on_ground());
    EXPECT_NEAR(plant.state().position_N.norm(), 0.0, 1e-9);
    EXPECT_NEAR(plant.state().q_NB.angularDistance(Quaternion::Identity()), 0.0, 1e-9);
    EXPECT_NEAR(plant.specific_force_B().z(), -kGravity, 1e-9);
}

TEST(Ground, stops_a_tilted_drop_upright) {
    VehicleState state;
    state.position_N.z() = -0.3;
    state.q_NB = math::from_euler(math::EulerAngles<double>{0.2, -0.1, 1.0});
    Plant plant(iris().airframe, state);
    EXPECT_FALSE(plant.is_on_ground());
    run(plant, 4.0);
    EXPECT_TRUE(plant.is_on_ground());
    EXPECT_NEAR(plant.state().velocity_N.norm(), 0.0, 1e-6);
    EXPECT_NEAR(plant.state().rate_B.norm(), 0.0, 1e-6);
    EXPECT_NEAR(plant.state().position_N.z(), 0.0, 1e-4);
    EXPECT_NEAR(math::tilt(plant.state().q_NB), 0.0, 1e-4);
}

TEST(Ground, stops_a_slide_by_friction) {
    VehicleState state;
    state.velocity_N.x() = 1.0;
    Plant plant(iris().airframe, state);
    run(plant, 2.0);
    // Coulomb: v^2 / (2 mu g). The springs of the feet blur it.
    EXPECT_NEAR(plant.state().position_N.x(), 1.0 / (2.0 * 0.7 * kGravity), 0.01);
    const Vector3 stopped = plant.state().position_N;
    run(plant, 10.0);
    EXPECT_NEAR((plant.state().position_N - stopped).norm(), 0.0, 1e-6);
}

TEST(Ground, holds_against_a_torque_that_friction_can_bear) {
    Plant plant(iris().airframe, VehicleState{});
    plant.command({0.4F, 0.4F, 0.0F, 0.0F});  // 0.34 N m of yaw; friction bears about 1.6
    run(plant, 2.0);
    const double yaw = math::heading(plant.state().q_NB);
    run(plant, 10.0);
    EXPECT_NEAR(math::heading(plant.state().q_NB), yaw, 1e-6);
}

TEST(Ground, carries_a_vehicle_on_its_back) {
    VehicleState state;
    state.position_N.z() = -0.2;
    state.q_NB = Quaternion(0.0, 1.0, 0.0, 0.0);
    Plant plant(iris().airframe, state);
    run(plant, 4.0);
    // Its hubs are 0.05 m above its centre, so they lie about 0.05 m above where feet stood.
    EXPECT_NEAR(plant.state().position_N.z(), 0.1 - 0.05, 0.01);
    EXPECT_NEAR(plant.state().velocity_N.norm(), 0.0, 1e-6);
}

TEST(Ground, lets_go) {
    Plant plant(iris().airframe, VehicleState{});
    plant.command({0.7F, 0.7F, 0.7F, 0.7F});
    run(plant, 1.0);
    EXPECT_FALSE(plant.is_on_ground());
    EXPECT_LT(plant.state().position_N.z(), -0.5);
}

}  // namespace
}  // namespace stator::world
