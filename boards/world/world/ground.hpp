// The ground under the vehicle: points of the airframe that rest on springs and dampers, and hold
// by friction.
//
// Normal force k d + c d', never pulling; d is how deep the point is. Friction is a spring from the
// place where the point stands (its anchor) and a damper, together at most mu times the normal
// force: what is pushed less than that stays for good, as a friction that is only viscous would
// not.
#pragma once

#include <array>
#include <vector>

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

// Where the airframe is and how it moves, as force laws need it.
struct Motion {
    Vector3 position_N;
    Vector3 velocity_N;
    Matrix3 R_NB;
    Vector3 rate_B;
};

inline constexpr unsigned kMaxContactPoints = 32;

struct GroundParameters {
    double stiffness = 1.0;  // N/m, each point; along the ground, too
    double damping = 0.0;    // N s/m, each point; along the ground, too
    double friction = 0.0;
    std::vector<Vector3> points_B{};  // the feet first; at most kMaxContactPoints
    unsigned feet = 0;                // what the vehicle stands on
};

class Ground {
  public:
    // `surface_z`: where the ground is, m down from the origin of N.
    Ground(const GroundParameters& parameters, double surface_z);

    Wrench wrench(const Motion& motion) const;
    // To be called once after each step: anchors points that came down, drags those that slipped.
    void settle(const Motion& motion);
    bool is_touched() const { return touched_ != 0; }

  private:
    struct Contact {
        Vector3 arm_B;  // from the centre of mass
        Vector3 place_N;
        Vector3 velocity_N = Vector3::Zero();
        double depth = 0.0;
        double normal = 0.0;  // N
    };
    Contact contact(unsigned point, const Motion& motion) const;
    Vector3 stretch(unsigned point, const Contact& contact) const;
    bool is_near(const Motion& motion) const;

    GroundParameters parameters_;
    double surface_z_;
    double reach_;                                      // m, of the farthest point
    std::array<Vector3, kMaxContactPoints> anchors_N_;  // of points in `touched_`
    unsigned touched_ = 0;                              // bit i: point i
};

}  // namespace stator::world
