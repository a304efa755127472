// The ground under the vehicle: points of the airframe that rest on springs and dampers, and hold
// by friction.
//
// Normal force k d + c d', never pulling; d is how deep the point is. Friction is a spring from the
// place where the point stands (its anchor) and a damper, together at most mu times the normal
// force: what is pushed less than that stays for good, as a friction that is only viscous would
// not. A wheel is such a point with another friction along it than across.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "world/wrench.hpp"

namespace stator::world {

inline constexpr unsigned kMaxContactPoints = 32;
inline constexpr unsigned kMaxWheels = 6;

// Rolls along the airframe, or where it is steered; across it holds by the ground's friction.
struct Wheel {
    Vector3 place_B = Vector3::Zero();
    double stiffness = 1.0;  // N/m
    double damping = 0.0;    // N s/m
    double rolling = 0.0;    // friction along the wheel,
    double brake = 0.0;      // and while it is braked
    int steered_by = -1;     // number of a control surface; -1: none
    double steering = 0.0;   // angle, positive to the right, over that of the surface
};

struct GroundParameters {
    double stiffness = 1.0;  // N/m, each point; along the ground, too
    double damping = 0.0;    // N s/m, each point; along the ground, too
    double friction = 0.0;
    std::vector<Vector3> points_B{};  // the feet first; at most kMaxContactPoints
    unsigned feet = 0;                // what the vehicle stands on, beside wheels
    std::vector<Wheel> wheels{};      // at most kMaxWheels

    unsigned contact_count() const {
        return static_cast<unsigned>(points_B.size() + wheels.size());
    }
};

// A vehicle that stands on its springs.
struct Rest {
    double pitch = 0.0;      // rad
    double surface_z = 0.0;  // m, of the ground below its centre of mass
};
// `weight` in N. Of feet and wheels that carry it between them.
Rest rest_of(const GroundParameters& parameters, double weight);

class Ground {
  public:
    // `surface_z`: where the ground is, m down from the origin of N.
    Ground(const GroundParameters& parameters, double surface_z);

    Wrench wrench(const Motion& motion) const;
    // To be called once after each step: anchors points that came down, drags those that slipped.
    void settle(const Motion& motion);
    // Of wheels, from now on.
    void brake(bool is_braked) { is_braked_ = is_braked; }
    void steer(unsigned wheel, double angle);
    bool is_touched() const { return touched_ != 0; }

  private:
    struct Contact {
        Vector3 arm_B;  // from the centre of mass
        Vector3 place_N;
        Vector3 velocity_N = Vector3::Zero();
        double depth = 0.0;
        double normal = 0.0;  // N
        double stiffness = 0.0;
        double damping = 0.0;
    };
    Contact contact(unsigned point, const Motion& motion) const;
    Vector3 stretch(unsigned point, const Contact& contact) const;
    // A force along the ground, cut to what friction holds; or a stretch, which is a force over
    // `stiffness`.
    Vector3 held(unsigned point, const Motion& motion, const Vector3& wanted_N, double normal,
                 double stiffness) const;
    bool is_near(const Motion& motion) const;

    GroundParameters parameters_;
    double surface_z_;
    double reach_;                                                   // m, of the farthest point
    std::array<Vector3, kMaxContactPoints + kMaxWheels> anchors_N_;  // of those in `touched_`
    std::array<Vector3, kMaxWheels> rolls_B_;  // where each wheel rolls, of unit length
    bool is_braked_ = true;
    std::uint64_t touched_ = 0;  // bit i: point i, after the points wheels
};

}  // namespace stator::world
