// Nonlinear path following guidance.
#include "npfg.hpp"

#include "stator/rotation.hpp"

namespace stator::apps::fw_guidance {

namespace {

constexpr float kSlowest = 1.0F;  // m/s: below it there is no direction
constexpr float kBuffer = 1.5F;   // m/s of airspeed, over which a course becomes infeasible
constexpr float kInside = 0.2F;   // of the radius of a curve, least distance to its middle

// Where a track error counts as far, m.
float far_error(float ground_speed, const NpfgGains& gains) {
    return math::max(ground_speed, kSlowest) * gains.period * gains.damping;
}

// The direction of the air velocity that makes the course `bearing`.
Vector2 heading_for(const Vector2& bearing, const Vector2& wind, float airspeed) {
    const float across = cross(wind, bearing);  // of the wind, to the left of the course
    const float along = wind.dot(bearing);
    const float wind_speed = math::norm(wind);
    const float left2 = math::square(airspeed) - math::square(across);
    const Vector2 right(-bearing.y(), bearing.x());
    const auto feasible = [&]() -> Vector2 {
        return (math::sqrt(math::max(left2, 0.0F)) * bearing + across * right) / airspeed;
    };
    // The margin by which the vehicle gets on along the course.
    const float progress = math::sqrt(math::max(left2, 0.0F)) + along;
    const bool may_stall_over_ground = wind_speed > airspeed - kBuffer;
    if (!may_stall_over_ground && left2 > 0.0F) return feasible();
    const float margin = left2 > 0.0F ? progress : 0.0F;
    const float share = math::clamp(margin / kBuffer, 0.0F, 1.0F);
    const float out2 = math::max(math::square(wind_speed) - math::square(airspeed), 0.0F);
    const Vector2 least_drift =
        math::normalized(Vector2(math::sqrt(out2) * bearing - wind), bearing);
    return math::normalized(Vector2(share * feasible() + (1.0F - share) * least_drift),
                            least_drift);
}

}  // namespace

float lateral_acceleration(const PathPoint& path, const AirMotion& motion, const NpfgGains& gains) {
    const float airspeed = math::max(motion.airspeed, kSlowest);
    const Vector2 to_path = path.position - motion.position;
    const float signed_error = cross(path.tangent, Vector2(-to_path));  // positive: right of it
    const Vector2 normal(path.tangent.y(), -path.tangent.x());          // to the left
    const Vector2 inward = signed_error >= 0.0F ? normal : Vector2(-normal);

    const float far = far_error(math::norm(motion.velocity), gains);
    const float near = 1.0F - math::min(math::abs(signed_error) / far, 1.0F);
    const math::SinCos<float> look = math::sincos(math::kHalfPi<float> * math::square(near));
    const Vector2 bearing =
        math::normalized(Vector2(look.cos * inward + look.sin * path.tangent), path.tangent);

    const Vector2 wanted = heading_for(bearing, motion.wind, airspeed);
    const Vector2 air = math::normalized(Vector2(motion.velocity - motion.wind), wanted);
    const float sine = cross(air, wanted);
    const float gain = 4.0F * math::kPi<float> * gains.damping / gains.period;
    const bool is_behind = air.dot(wanted) < 0.0F;
    const float turn = is_behind ? math::copysign(1.0F, sine) : sine;

    // What the curve of the path asks for, in the air that moves over it.
    const float across = cross(motion.wind, path.tangent);
    const float along = motion.wind.dot(path.tangent);
    const float forward = math::sqrt(
        math::max(math::square(airspeed) - math::square(across), math::square(kSlowest)));
    const float speed = math::max(motion.velocity.dot(path.tangent), 0.0F);
    const float inside = math::max(1.0F - path.curvature * signed_error, kInside);
    const float curve =
        airspeed * (1.0F + math::max(along / forward, -1.0F)) * path.curvature * speed / inside;
    return gain * airspeed * turn + math::square(look.sin) * curve;
}

}  // namespace stator::apps::fw_guidance
