// The simulated sensors that place a vehicle on Earth: magnetometer, barometer, satellite receiver.
#pragma once

#include "world/earth.hpp"
#include "world/noise.hpp"
#include "world/plant.hpp"
#include "world/sensors.hpp"

namespace stator::world {

// A Honeywell HMC5883L beside the power wires, after the calibration that every vehicle gets.
struct MagnetometerParameters {
    std::uint64_t period_us = 10000;
    double noise = 0.002;         // gauss, field resolution of its data sheet
    double hard_iron = 0.010;     // gauss, what is left after calibration; drawn once a flight
    double gauss_per_amp = 2e-4;  // of the battery's current, along an axis drawn once a flight
    double steps = 1090.0;        // 1/gauss, gain of its data sheet
};

class Magnetometer {
  public:
    Magnetometer(const MagnetometerParameters& parameters, const Earth& earth, std::uint64_t seed);
    Vector3f measure(const VehicleState& state, double current);  // gauss

  private:
    MagnetometerParameters parameters_;
    math::Random random_;
    Vector3 field_N_;
    Vector3 hard_iron_B_;
    Vector3 per_amp_B_;
};

// A TE MS5611. Data sheet MS5611-01BA03; what is not there is an estimate.
struct BarometerParameters {
    std::uint64_t period_us = 20000;
    double noise = 1.2;            // Pa: 0.012 mbar at the most oversampling
    double offset = 50.0;          // Pa: accuracy 1.5 mbar, as three standard deviations
    double drift = 15.0;           // Pa, of weather and warming; a Gauss-Markov process
    double drift_tau = 600.0;      // s
    double ram = -0.1;             // of the dynamic pressure: wind sucks at the vehicle's shell
    double wash = 5.0;             // Pa, of the rotors' wash when they carry the weight
    double steps = 1.0;            // 1/Pa: 0.01 mbar
    double warmer_by_degc = 15.0;  // than the air
};

struct BarometerSample {
    float pressure;  // Pa
    float temperature_degc;
};

class Barometer {
  public:
    Barometer(const BarometerParameters& parameters, const Earth& earth, std::uint64_t seed);
    // To be called once each period.
    BarometerSample measure(const Plant& plant);

  private:
    BarometerParameters parameters_;
    Earth earth_;
    math::Random random_;
    double offset_;
    GaussMarkov drift_;
};

// A u-blox NEO-M8 under a clear sky: 2.5 m CEP over a day (its data sheet), most of it slow. A
// Gauss-Markov process of 1100 s is the model of Beard and McLain, Small Unmanned Aircraft, 7.5.
struct GnssParameters {
    std::uint64_t period_us = 200000;
    std::uint64_t least_delay_us = 90000;  // from the instant of the fix to its arrival
    std::uint64_t most_delay_us = 130000;  // below the period
    Vector3 slow{1.2, 1.2, 2.4};           // m: satellites, ionosphere
    double slow_tau = 1100.0;              // s
    Vector3 fast{0.15, 0.15, 0.25};        // m: reflections
    double fast_tau = 10.0;                // s
    Vector3 velocity{0.06, 0.06, 0.10};    // m/s
    double velocity_tau = 0.5;             // s
    double loss = 0.005;                   // of fixes that never arrive
    std::uint32_t satellites = 14;
};

struct GnssFix {
    std::uint64_t time_us = 0;  // of the fix
    Geodetic place{};
    Vector3f velocity_N = Vector3f::Zero();
    float horizontal_error = 0.0F;  // m, as the receiver believes
    float vertical_error = 0.0F;    // m
    float speed_error = 0.0F;       // m/s
    std::uint32_t satellites = 0;   // none: no fix
};

// What is wrong with a satellite receiver's world.
struct GnssFault {
    bool lost = false;
    double glitch = 0.0;  // m, by which it is pulled away
};

class GnssReceiver {
  public:
    GnssReceiver(const GnssParameters& parameters, const Earth& earth, std::uint64_t seed);

    struct Sending {
        std::uint64_t arrival_us;
        bool arrives;
        GnssFix fix;
    };
    // To be called once each period.
    Sending measure(const Plant& plant, const GnssFault& fault);

  private:
    GnssFix fix(const Plant& plant, const Vector3& position_N, const Vector3& velocity_error) const;

    GnssParameters parameters_;
    Earth earth_;
    math::Random random_;
    GaussMarkov slow_;
    GaussMarkov fast_;
    GaussMarkov velocity_;
    Vector3 pulled_towards_N_;  // by a glitch; of unit length
};

}  // namespace stator::world
