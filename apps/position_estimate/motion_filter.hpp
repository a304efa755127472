// Position and velocity of a point, from its acceleration and late measurements of its position.
//
//     p' = v,  v' = a_measured - e,  e' = 0
//
// e is what the acceleration is wrong by: accelerometer bias and gravity seen under a small tilt
// error, both nearly constant in N. The gains are those of the steady state of a Kalman filter: for
// white noise in acceleration and position, (s^2 + sqrt(2) w s + w^2), with w^4 the ratio of their
// densities, times (s + w_e) for the slower e. So they need no covariance, and no time to settle.
//
// A measurement is compared with where the point was when it was made: from the newest estimate
// back, p - v d + a d^2 / 2. Over 10 ms that leaves out jerk d^3 / 6, a hundredth of a millimetre
// at 60 m/s^3: no history of estimates is needed.
#pragma once

#include "stator/rotation.hpp"

namespace stator::apps::position_estimate {

class MotionFilter {
  public:
    using Vector = math::Vector3<float>;

    const Vector& position() const { return position_; }
    const Vector& velocity() const { return velocity_; }

    // Begins again, and keeps what is known of the acceleration's error.
    void restart(const Vector& position, const Vector& velocity);
    // Moves on by `dt` seconds with the acceleration in N.
    void predict(const Vector& acceleration, float dt);
    // Where the point was `age` seconds ago; negative: where it will be.
    Vector position_ago(float age) const;
    // Corrects with a measurement less position_ago(its age), `dt` seconds after the one before.
    void correct(const Vector& innovation, float dt, float bandwidth, float error_bandwidth);

  private:
    Vector position_ = Vector::Zero();
    Vector velocity_ = Vector::Zero();
    Vector acceleration_ = Vector::Zero();  // corrected
    Vector error_ = Vector::Zero();
};

}  // namespace stator::apps::position_estimate
