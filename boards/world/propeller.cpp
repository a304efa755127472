// A propeller that pulls or pushes along the vehicle, and its motor.
#include "world/propeller.hpp"

#include <cstddef>

namespace stator::world {

namespace {

constexpr double kSlowest = 100.0;  // rad/s; slower, a motor's torque rises no more
constexpr double kSeaDensity = 1.225;

}  // namespace

double polynomial(const std::vector<double>& coefficients, double x) {
    double sum = 0.0;
    for (std::size_t i = coefficients.size(); i-- > 0;) sum = sum * x + coefficients[i];
    return sum;
}

double static_thrust(const Propeller& propeller, double speed) {
    const double square = math::square(speed * propeller.diameter / math::kTwoPi<double>);
    return propeller.thrust[0] * kSeaDensity * square * math::square(propeller.diameter);
}

PropellerOutput turn(const Propeller& propeller, const PropellerInput& input) {
    const Vector3 hub_B = input.velocity_B + input.rate_B.cross(propeller.place_B);
    const double inflow = math::max(hub_B.dot(propeller.axis_B), 0.0);
    const double tip = input.speed * propeller.diameter / math::kTwoPi<double>;  // n D
    const bool is_fast = inflow >= propeller.most_advance * tip;
    const double advance = is_fast ? propeller.most_advance : inflow / tip;
    const double size = input.air_density * math::square(tip * propeller.diameter);
    const double thrust = input.efficiency * polynomial(propeller.thrust, advance) * size;
    const double drag =
        polynomial(propeller.power, advance) * size * propeller.diameter / math::kTwoPi<double>;
    double motor = input.shaft_power / math::max(input.speed, kSlowest);
    // It brakes, but turns nothing backwards.
    if (input.speed <= 0.0) motor = math::max(motor, 0.0);
    const double spin = propeller.turns_cw * propeller.inertia * input.speed;
    const Vector3 force_B = thrust * propeller.axis_B;
    const Vector3 torque_B = propeller.place_B.cross(force_B) -
                             propeller.turns_cw * motor * propeller.axis_B -
                             input.rate_B.cross(spin * propeller.axis_B);
    return {.wrench = {force_B, torque_B}, .speed_rate = (motor - drag) / propeller.inertia};
}

}  // namespace stator::world
