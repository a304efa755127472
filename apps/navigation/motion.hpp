// What an IMU feels over a time: turns, and changes of velocity and position in the frame that the
// body had at its beginning, gravity left out.
//
//     R_1 = R_0 turn,  v_1 = v_0 + g t + R_0 velocity,  p_1 = p_0 + v_0 t + g t^2 / 2 + R_0
//     position
//
// Motions compose exactly, whatever the vehicle does: so samples can be summed into steps without
// coning and sculling errors, and parts taken off again (C. Forster, L. Carlone, F. Dellaert,
// D. Scaramuzza, "On-manifold preintegration for real-time visual-inertial odometry", TRO 2017).
#pragma once

#include "stator/rotation.hpp"

namespace stator::apps::navigation {

using Vector = math::Vector3<float>;
using Quaternion = math::Quaternion<float>;

struct Motion {
    Quaternion turn = Quaternion::Identity();
    Vector velocity = Vector::Zero();
    Vector position = Vector::Zero();
    float time = 0.0F;  // s
};

// First `a`, then `b`.
inline Motion operator*(const Motion& a, const Motion& b) {
    const math::Matrix3<float> R = a.turn.toRotationMatrix();
    return {.turn = a.turn * b.turn,
            .velocity = a.velocity + R * b.velocity,
            .position = a.position + a.velocity * b.time + R * b.position,
            .time = a.time + b.time};
}

// What follows `a` to make `b`: a * between(a, b) is b.
inline Motion between(const Motion& a, const Motion& b) {
    const math::Matrix3<float> R = a.turn.toRotationMatrix();
    const float time = b.time - a.time;
    return {.turn = a.turn.conjugate() * b.turn,
            .velocity = R.transpose() * (b.velocity - a.velocity),
            .position = R.transpose() * (b.position - a.position - a.velocity * time),
            .time = time};
}

// Constant rate and force in B. In N the force turns; kept to first order in the angle.
inline Motion constant_motion(const Vector& rate_B, const Vector& force_B, float time) {
    const Vector angle = rate_B * time;
    return {.turn = math::from_rotation_vector(angle),
            .velocity = (force_B + angle.cross(force_B) * 0.5F) * time,
            .position = force_B * (0.5F * time * time),
            .time = time};
}

}  // namespace stator::apps::navigation
