// A vehicle whose true motion is known, its sensors, and the attitude node that listens to them.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "attitude.hpp"
#include "stator/random.hpp"
#include "stator/testing.hpp"

namespace stator::testing {

class AttitudeRig {
  public:
    using Vector = math::Vector3<double>;
    using Quaternion = math::Quaternion<double>;
    // What happens `t` seconds into a run.
    using Motion = std::function<Vector(double t)>;

    // What the sensors add to the truth; units of the messages.
    Vector gyro_bias{0, 0, 0};
    double gyro_noise = 0;
    double accel_noise = 0;
    Vector disturbance_B{0, 0, 0};  // gauss
    Vector field_N{0.2, 0.0, 0.4};  // gauss, dips by 63 deg
    uint64_t period_us = 1000;
    uint64_t mag_period_us = 0;      // 0: no magnetometer
    uint64_t capture_period_us = 0;  // 0: no motion capture
    uint64_t capture_delay_us = 5000;
    bool has_status = false;
    bool armed = false;
    AttitudeParams params;  // the interface's defaults, the tuning that the tests are about

    Quaternion q_NB = Quaternion::Identity();  // truth
    Quaternion estimate = Quaternion::Identity();
    uint64_t now_us = 0;
    unsigned published = 0;

    // Runs for `seconds` with this body rate (in B) and acceleration (in N).
    void run(double seconds, const Motion& rate_B, const Motion& acceleration_N);
    void rest(double seconds) { run(seconds, kNone, kNone); }
    // One activation with the samples as they are. True if it published.
    bool step(const SensorGyro& gyro, const SensorAccel& accel, const SensorMag* mag = nullptr,
              const VehicleOdometry* seen = nullptr);

    // Errors of the estimate, rad.
    double tilt_error() const;
    double heading_error() const;  // true minus estimated
    // Root mean square of tilt_error over the last run.
    double tilt_rms() const { return tilt_rms_; }

    static Vector kNone(double) { return Vector::Zero(); }
    static Motion constant(const Vector& v) {
        return [v](double) { return v; };
    }

  private:
    Vector noise(double sigma);
    VehicleOdometry seen_now() const;

    apps::attitude::Attitude node_;
    math::Random random_{1};
    std::vector<VehicleOdometry> on_the_way_;
    double tilt_rms_ = 0;
};

}  // namespace stator::testing
