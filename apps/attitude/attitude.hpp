// Attitude estimation, between the IMU and everything that must know which way is up.
//
//     q_NB = q_NT (heading, one angle) * q_TI (inclination) * q_IB (integrated gyro)
//
// after the idea of D. Laidig and T. Seel, "VQF: Highly accurate IMU orientation estimation with
// bias estimation and magnetic disturbance rejection", Information Fusion 91, 2023: the frame I in
// which the gyro is integrated is never corrected, so that there the specific force can be averaged
// for seconds while the vehicle turns. The default parameters are the paper's.
#pragma once

#include <optional>

#include "attitude_ports.hpp"
#include "gyro_bias.hpp"
#include "heading.hpp"
#include "inclination.hpp"
#include "magnetic_field.hpp"

namespace stator::apps::attitude {

// Time between samples of one sensor.
class SampleClock {
  public:
    // True if `interval_us` have passed since `advance`, or it was never called.
    bool is_due(uint64_t timestamp_us, uint64_t interval_us) const {
        return !started_ || (timestamp_us > last_us_ && timestamp_us - last_us_ >= interval_us);
    }
    // Seconds since the sample before, 0 for the first; none if this one is not newer.
    std::optional<float> advance(uint64_t timestamp_us) {
        if (started_ && timestamp_us <= last_us_) return std::nullopt;
        const uint64_t elapsed_us = started_ ? timestamp_us - last_us_ : 0;
        started_ = true;
        last_us_ = timestamp_us;
        return static_cast<float>(elapsed_us) * 1e-6F;
    }

  private:
    uint64_t last_us_ = 0;
    bool started_ = false;
};

class Attitude {
  public:
    // Publishes once per gyro sample, from the first accelerometer sample on: level is known from
    // then, and north is where the nose points until a heading reference comes. A sample that is
    // not finite, or not newer than the one before, is left out. Without a heading reference the
    // heading drifts; without the accelerometer the inclination does.
    void step(AttitudePorts& ports);

  private:
    using Vector = math::Vector3<float>;

    void restart();
    void update_inclination(AttitudePorts& ports);
    void correct_inclination(float dt, bool may_rest, const AttitudeParams& params);
    void update_heading(AttitudePorts& ports);
    void use_motion_capture(const VehicleOdometry& seen, const AttitudeParams& params);
    void use_magnetometer(const SensorMag& sample, const AttitudeParams& params);

    Inclination inclination_;
    Heading heading_;
    GyroBias bias_;
    MagneticField field_;
    FollowGain mag_gain_;
    FollowGain capture_gain_;
    SampleClock gyro_clock_;
    SampleClock correction_clock_;
    SampleClock mag_clock_;
    SampleClock capture_clock_;
    Vector rate_B_ = Vector::Zero();  // as measured
    Average rates_B_;
    Average forces_B_;
    uint64_t capture_until_us_ = 0;  // the magnetometer is not used before
    bool aligned_ = false;
};

}  // namespace stator::apps::attitude
