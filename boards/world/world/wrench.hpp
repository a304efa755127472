// Forces and motions as the parts of the plant exchange them.
#pragma once

#include "stator/rotation.hpp"

namespace stator::world {

using Vector3 = math::Vector3<double>;
using Matrix3 = math::Matrix3<double>;
using Quaternion = math::Quaternion<double>;

// What acts on the vehicle at its centre of mass, but for gravity: what an accelerometer feels.
struct Wrench {
    Vector3 force_B = Vector3::Zero();   // N
    Vector3 torque_B = Vector3::Zero();  // N m
};

inline Wrench operator+(const Wrench& a, const Wrench& b) {
    return {a.force_B + b.force_B, a.torque_B + b.torque_B};
}

// Where the airframe is and how it moves, as force laws need it.
struct Motion {
    Vector3 position_N;
    Vector3 velocity_N;
    Matrix3 R_NB;
    Vector3 rate_B;
};

}  // namespace stator::world
