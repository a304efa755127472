// The heading of the level frame T against north: one angle, kept apart from the inclination so
// that no magnetic disturbance can tilt the estimate.
#pragma once

#include "low_pass.hpp"
#include "stator/rotation.hpp"

namespace stator::apps::attitude {

class Heading {
  public:
    // Turns a vector or an attitude from T to N.
    const math::Quaternion<float>& q_NT() const { return q_NT_; }

    // Error of a heading that was measured in T and should be `reference` in N; -pi to pi.
    float error(float measured_T, float reference) const {
        return math::wrap_pi(reference - measured_T - angle_);
    }
    void turn(float angle) {
        angle_ = math::wrap_pi(angle_ + angle);
        q_NT_ = math::from_axis_angle(math::Vector3<float>(0.0F, 0.0F, 1.0F), angle_);
    }

  private:
    float angle_ = 0.0F;
    math::Quaternion<float> q_NT_ = math::Quaternion<float>::Identity();
};

}  // namespace stator::apps::attitude
