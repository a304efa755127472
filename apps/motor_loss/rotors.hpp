// The four rotors of a quadrotor, and how the mass lies about its centre.
#pragma once

#include <array>

#include "stator/rotation.hpp"

namespace stator::apps::motor_loss {

inline constexpr unsigned kRotors = 4;
using Commands = std::array<float, kRotors>;  // thrust of each, 0 to 1 of its most
using Vector2 = Eigen::Matrix<float, 2, 1>;
using Vector3 = math::Vector3<float>;

struct Quad {
    std::array<Vector2, kRotors> place_B;  // m, of each rotor: forward, rightward
    Vector3 gyration2 = Vector3::Zero();   // m^2, inertia over mass about each axis of B

    // Roll and pitch torque of a unit of thrust along -z of B.
    Vector2 arm(unsigned i) const { return {-place_B[i].y(), place_B[i].x()}; }
    // Roll and pitch of rate x inertia * rate, over the mass.
    Vector2 gyroscopic(const Vector3& rate) const {
        return {rate.y() * rate.z() * (gyration2.z() - gyration2.y()),
                rate.z() * rate.x() * (gyration2.x() - gyration2.z())};
    }
};

}  // namespace stator::apps::motor_loss
