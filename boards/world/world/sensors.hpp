// What the simulated sensors make of the truth: bias, noise, vibration, delay, resolution.
#pragma once

#include "world/noise.hpp"
#include "world/plant.hpp"

namespace stator::world {

using Vector3f = math::Vector3<float>;

// An MPU-6000, after the calibration that every vehicle gets. PS is its Product Specification,
// PS-MPU-6000A rev. 3.4.
struct ImuParameters {
    std::uint64_t period_us = 1000;
    // White noise at 1 kHz: density times the square root of 500 Hz, the band up to Nyquist.
    float gyro_noise = 0.00195F;  // rad/s: 0.005 deg/s/sqrt(Hz), PS 6.1
    float accel_noise = 0.0877F;  // m/s^2: 400 ug/sqrt(Hz), PS 6.2
    // Standard deviations of what is left after calibration, drawn once a flight. Gyro: 0.6 deg/s
    // of its 20 deg/s. Accelerometer: levelled to 0.1 deg, 1.7 mg.
    float gyro_bias = 0.01F;     // rad/s
    float accel_bias = 0.0167F;  // m/s^2
    // In flight it warms by some degrees, and zeros move with it; standard deviations again.
    // PS 6.1: 20 deg/s for 125 degC, taken as three of them; PS 6.2: 35 mg for 70 degC.
    double warms_by_degc = 2.0;
    double warming_tau = 60.0;       // s
    double gyro_per_degc = 0.00093;  // rad/s
    double accel_per_degc = 0.0049;  // m/s^2
    // What no calibration takes away: Gauss-Markov processes with the lowest Allan deviation that
    // such parts show, 0.002 deg/s and 0.1 mg, near 190 s.
    double gyro_instability = 5.6e-5;   // rad/s
    double accel_instability = 1.6e-3;  // m/s^2
    double instability_tau = 100.0;     // s
    std::uint64_t drift_samples = 100;  // zeros creep, so that they are looked at now and then
    // Vibration when all rotors turn at hover speed; goes with the square of a rotor's speed. In
    // flight records noise is 10 to 50 times the data sheet's; this makes 19 (gyro) and 12 (accel).
    float gyro_shake = 0.03F;       // rad/s, white
    float accel_shake = 0.8F;       // m/s^2, white
    float gyro_imbalance = 0.015F;  // rad/s, amplitude of each rotor's line
    float accel_imbalance = 0.5F;   // m/s^2, amplitude of each rotor's line
    // Resolution and range of 16 bits, PS 6.1 and 6.2.
    float gyro_steps = 939.6507F;   // 1/(rad/s): 16.4 in 1 deg/s, to 2000 deg/s
    float accel_steps = 208.8372F;  // 1/(m/s^2): 2048 in 1 g, to 16 g
};

struct ImuSample {
    Vector3f gyro_B;
    Vector3f accel_B;
};

class Imu {
  public:
    Imu(const ImuParameters& parameters, unsigned rotors, std::uint64_t seed);
    // To be called once each period.
    ImuSample measure(const Plant& plant);

  private:
    Vector3f rotor_lines(const Plant& plant);
    void drift();

    ImuParameters parameters_;
    math::Random random_;
    math::Random drift_random_;
    Vector3f gyro_bias_;
    Vector3f accel_bias_;
    Vector3 gyro_per_degc_;
    Vector3 accel_per_degc_;
    GaussMarkov gyro_wander_;
    GaussMarkov accel_wander_;
    Vector3f gyro_offset_;  // bias and drift, as they are now
    Vector3f accel_offset_;
    std::uint64_t samples_ = 0;
    std::array<double, kMaxRotors> rotor_angles_{};  // rad
};

// Cameras in a laboratory that see markers on the vehicle. Position and heading only.
struct MocapParameters {
    std::uint64_t period_us = 10000;
    std::uint64_t delay_us = 5000;  // from picture to arrival, below the period
    float position_noise = 0.001F;  // m
    float yaw_noise = 0.0035F;      // rad, 0.2 deg: millimetres over an airframe's half metre
};

struct MocapSample {
    std::uint64_t time_us = 0;
    Vector3f position_N = Vector3f::Zero();
    float yaw = 0.0F;
};

class Mocap {
  public:
    Mocap(const MocapParameters& parameters, std::uint64_t seed);
    MocapSample measure(const Plant& plant);

  private:
    MocapParameters parameters_;
    math::Random random_;
};

}  // namespace stator::world
