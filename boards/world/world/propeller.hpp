// A propeller that pulls or pushes along the vehicle, and its motor.
//
//   T = CT(J) rho n^2 D^4   Q = CP(J) rho n^2 D^5 / (2 pi)   J = V / (n D)   (n: turns a second)
//   I w' = P(throttle) / w - Q
// The motor's torque turns the airframe the other way, and the propeller is a gyroscope.
#pragma once

#include <array>
#include <vector>

#include "world/wrench.hpp"

namespace stator::world {

inline constexpr unsigned kMaxPropellers = 2;
using PropellerSpeeds = Eigen::Matrix<double, kMaxPropellers, 1>;  // rad/s; 0 without a propeller

struct Propeller {
    Vector3 place_B = Vector3::Zero();  // m, from the centre of mass
    Vector3 axis_B = Vector3::UnitX();  // along its thrust
    double turns_cw = 1.0;              // 1: clockwise seen from behind; -1: counter-clockwise
    double diameter = 1.0;              // m
    double inertia = 1.0;               // kg m^2, of all that spins
    double most_advance = 1.0;          // the J up to which the polynomials hold
    double efficiency = 1.0;            // of motor and controller
    std::vector<double> thrust{};       // CT, polynomial of J, the lowest power first
    std::vector<double> power{};        // CP
    std::vector<double> shaft_power{};  // W, polynomial of the throttle at the nominal voltage
};

struct PropellerInput {
    Vector3 velocity_B = Vector3::Zero();  // of the vehicle against the air
    Vector3 rate_B = Vector3::Zero();
    double air_density = 1.225;
    double speed = 0.0;        // rad/s
    double shaft_power = 0.0;  // W
    double efficiency = 1.0;   // of the thrust: of a propeller with a fault
};

struct PropellerOutput {
    Wrench wrench{};
    double speed_rate = 0.0;  // rad/s^2
};

double polynomial(const std::vector<double>& coefficients, double x);
PropellerOutput turn(const Propeller& propeller, const PropellerInput& input);
// N, standing still at sea level.
double static_thrust(const Propeller& propeller, double speed);

}  // namespace stator::world
