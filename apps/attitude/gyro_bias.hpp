// Gyro bias, from what the other corrections have to undo, and from rest.
//
// A Kalman filter of the bias b in B. What of it is not yet known turns the attitude estimate away;
// the corrections of inclination (and of heading, against motion capture) see that drift through
// their low-pass: drift = LP(R_TB (b - b_estimate)). So a row of LP(R_TB) is the measurement's
// direction, and drift + LP(R_TB b_estimate) the measurement.
#pragma once

#include "attitude_ports.hpp"
#include "low_pass.hpp"
#include "stator/rotation.hpp"

namespace stator::apps::attitude {

class GyroBias {
  public:
    using Vector = math::Vector3<float>;

    const Vector& value() const { return bias_; }
    bool at_rest() const { return at_rest_; }

    // Lets uncertainty grow for the time `dt`.
    void predict(float dt, const AttitudeParams& params);
    // Looks for rest, and takes the mean rate as the bias when it finds it.
    void update_rest(const Vector& rate_B, const Vector& force_B, bool may_rest, float dt,
                     const AttitudeParams& params);
    // `drift_T`: per second, about T's first two axes.
    void update_inclination(const math::Matrix3<float>& R_TB, const Eigen::Vector2f& drift_T,
                            float dt, float time_constant, const AttitudeParams& params);
    // `drift`: per second, about T's third axis; `gain`: the part of the heading's error that was
    // corrected.
    void update_heading(const math::Matrix3<float>& R_TB, float drift, float gain, float dt,
                        const AttitudeParams& params);
    // Forgets what was low-passed, not the bias.
    void restart();

  private:
    void correct(const Vector& direction, float innovation, float noise);

    Vector bias_ = Vector::Zero();
    math::Matrix3<float> covariance_ = math::Matrix3<float>::Zero();
    bool started_ = false;
    bool at_rest_ = false;
    float quiet_s_ = 0.0F;
    LowPass<Vector> rate_B_;
    LowPass<Vector> force_B_;
    // Per row: a row of R_TB, and that row times the estimate.
    LowPass<Eigen::Matrix<float, 2, 4>> inclination_;
    Eigen::Vector4f heading_ = Eigen::Vector4f::Zero();
};

}  // namespace stator::apps::attitude
