// The air's force on a wing with its tail and control surfaces.
//
// Derivatives, as flight mechanics has them (Stevens and Lewis, Aircraft Control and Simulation,
// 2.3), in wind axes; rates count as p b / 2V, q c / 2V and r b / 2V, angles in radians:
//   CL = CL0 + CLa alpha + CLq q + sum CLd d            CY, Cl, Cn = b beta + p p + r r + sum d
//   CD = CD0 + CDa alpha + CDa2 alpha^2 + k (CL - CLmin)^2 + beta terms + sum (|d| and d^2 terms)
//   Cm = Cm0 + Cma alpha + Cmq q + sum Cmd d
// From `stall_begins` on, what depends on alpha alone in CL, CD and Cm blends into a curve up to
// 180 deg, mirrored for negative alpha; surfaces and the damping of roll fade.
#pragma once

#include <array>
#include <vector>

#include "world/wrench.hpp"

namespace stator::world {

inline constexpr unsigned kMaxSurfaces = 8;
using Deflections = std::array<double, kMaxSurfaces>;  // rad; 0 without a surface
using ServoControls = std::array<float, kMaxSurfaces>;

// The part of an effect at an angle of attack: 1 up to `from`, `left` beyond `to`.
struct Fading {
    double from = 4.0;  // rad
    double to = 5.0;
    double left = 1.0;

    double part(double alpha) const;
};

// A control surface and its servo. Coefficients are for a radian.
struct Surface {
    double least = 0.0;          // rad
    double most = 0.0;           // rad, at command 1
    double rate = 0.0;           // rad/s, the most
    double time_constant = 0.0;  // s
    double lift = 0.0;
    double drag = 0.0;   // of |deflection|
    double drag2 = 0.0;  // of its square
    double side = 0.0;
    double roll = 0.0;
    double pitch = 0.0;
    double yaw = 0.0;
    Fading fades{};
};

struct Lateral {
    double beta = 0.0;
    double roll_rate = 0.0;
    double yaw_rate = 0.0;
};

struct StallPoint {
    double alpha;
    double lift;
    double drag;
    double pitch;
};

struct Wing {
    double area = 0.0;                      // m^2; 0: there is no wing
    double span = 0.0;                      // m
    double chord = 0.0;                     // m
    Vector3 reference_B = Vector3::Zero();  // m, where the forces act
    double lift_zero = 0.0;
    double lift_alpha = 0.0;
    double lift_pitch_rate = 0.0;
    double drag_zero = 0.0;
    double drag_alpha = 0.0;
    double drag_alpha2 = 0.0;
    double drag_beta = 0.0;
    double drag_beta2 = 0.0;
    double drag_lift2 = 0.0;
    double drag_least_lift = 0.0;
    Lateral side{};
    Lateral roll{};
    Lateral yaw{};
    double pitch_zero = 0.0;
    double pitch_alpha = 0.0;
    double pitch_pitch_rate = 0.0;
    double stall_begins = 4.0;        // rad
    double stall_blend = 1.0;         // rad
    std::vector<StallPoint> curve{};  // by rising alpha
    Fading roll_damping{};
    std::vector<Surface> surfaces{};  // at most kMaxSurfaces
};

// `velocity_B`, `rate_B`: against the air. About the centre of mass.
Wrench wing_wrench(const Wing& wing, const Deflections& deflections, const Vector3& velocity_B,
                   const Vector3& rate_B, double air_density);

// Where the servos are `dt` later. Not a number commands neutral.
void move_servos(const Wing& wing, const ServoControls& control, double dt,
                 Deflections& deflections);

}  // namespace stator::world
