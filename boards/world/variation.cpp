// The simulated vehicle of one flight.
#include "world/variation.hpp"

namespace stator::world {

namespace {

// 1 - part to 1 + part.
double factor(double part, math::Random& random) {
    return 1.0 + part * (2.0 * random.uniform_double() - 1.0);
}

// Arms are counted from the centre of gravity.
void move_centre(Airframe& airframe, double x, double y) {
    for (Rotor& rotor : airframe.rotors) rotor.place_B -= Vector3(x, y, 0.0);
    for (Vector3& point_B : airframe.ground.points_B) point_B -= Vector3(x, y, 0.0);
    for (Wheel& wheel : airframe.ground.wheels) wheel.place_B -= Vector3(x, y, 0.0);
    for (Propeller& propeller : airframe.propellers) propeller.place_B -= Vector3(x, y, 0.0);
    airframe.wing.reference_B -= Vector3(x, y, 0.0);
}

}  // namespace

Vehicle vary(Vehicle vehicle, const Variation& variation, std::uint64_t seed) {
    math::Random random(seed, static_cast<std::uint64_t>(Stream::kVariation));
    vehicle.airframe.mass *= factor(variation.mass, random);
    Inertia& inertia = vehicle.airframe.inertia;
    for (double* moment : {&inertia.xx, &inertia.yy, &inertia.zz}) {
        *moment *= factor(variation.inertia, random);
    }
    const double thrust = factor(variation.thrust, random);
    vehicle.airframe.thrust_per_speed2 *= thrust;
    for (Propeller& propeller : vehicle.airframe.propellers) {
        for (double& coefficient : propeller.thrust) coefficient *= thrust;
    }
    const double x = variation.centre * (factor(1.0, random) - 1.0);
    const double y = variation.centre * (factor(1.0, random) - 1.0);
    move_centre(vehicle.airframe, x, y);
    const double delay_us = 1e6 * variation.most_delay * random.uniform_double();
    vehicle.command_delay_us = math::saturate<std::uint64_t>(math::round(delay_us));
    vehicle.imu.gyro_bias *= static_cast<float>(variation.bias);
    vehicle.imu.accel_bias *= static_cast<float>(variation.bias);
    vehicle.magnetometer.hard_iron *= variation.bias;
    vehicle.barometer.offset *= variation.bias;
    return vehicle;
}

}  // namespace stator::world
