// Nonlinear path following guidance: the lateral acceleration that leads an aeroplane onto a path
// and along it, in any wind. Stastny and Siegwart: On Flying Backwards: Preventing Run-away of
// Small, Low-speed, Fixed-wing UAVs in Strong Winds, IROS 2019.
#pragma once

#include <Eigen/Core>

namespace stator::apps::fw_guidance {

using Vector2 = Eigen::Matrix<float, 2, 1>;  // north, east

// Where the path is nearest.
struct PathPoint {
    Vector2 position;
    Vector2 tangent;  // of unit length
    float curvature;  // 1/m; positive turns right
};

struct AirMotion {
    Vector2 position;
    Vector2 velocity;  // over ground
    Vector2 wind;
    float airspeed;  // true
};

struct NpfgGains {
    float period;  // s
    float damping;
};

// Far from the path the wanted course leads straight to it, near it along it:
//
//     e = |track error| / (ground speed * period * damping), at most 1
//     look-ahead = pi/2 (1 - e)^2       course = cos(look-ahead) normal + sin(look-ahead) tangent
//
// The air velocity for that course follows from the wind triangle. A course that the wind does not
// allow becomes the nearest that drifts least: in a wind that is stronger than the airspeed, the
// nose turns into the wind. The acceleration turns the air velocity there, and adds the curvature
// of the path near it.
float lateral_acceleration(const PathPoint& path, const AirMotion& motion, const NpfgGains& gains);

// Towards the right.
inline float cross(const Vector2& a, const Vector2& b) {
    return a.x() * b.y() - a.y() * b.x();
}

}  // namespace stator::apps::fw_guidance
