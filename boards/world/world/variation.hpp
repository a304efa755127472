// The simulated vehicle of one flight: as published, or one of many that differ from that.
#pragma once

#include "world/battery.hpp"
#include "world/navigation_sensors.hpp"
#include "world/plant.hpp"
#include "world/sensors.hpp"

namespace stator::world {

struct Vehicle {
    Airframe airframe{};
    BatteryParameters battery{};
    ImuParameters imu{};
    MagnetometerParameters magnetometer{};
    BarometerParameters barometer{};
    std::uint64_t command_delay_us = 0;  // from the command to the motor
};

// Drawn evenly within these limits, the sensors' biases twice as large as calibration leaves them.
struct Variation {
    double mass = 0.15;        // part of it
    double inertia = 0.20;     // each axis
    double thrust = 0.10;      // all rotors and propellers alike
    double centre = 0.01;      // m, of gravity, forward and to the right
    double most_delay = 6e-3;  // s
    double bias = 2.0;
};
Vehicle vary(Vehicle vehicle, const Variation& variation, std::uint64_t seed);

}  // namespace stator::world
