// Position and velocity control of a point mass.
#include "motion.hpp"

namespace stator::apps::position_control {

using math::Vector3;

namespace {

constexpr float kGravity = 9.80665F;
constexpr int kDown = 2;

float finite_or_zero(float x) {
    return math::is_finite(x) ? x : 0.0F;
}

// v with its horizontal part at most `limit` long.
Vector3<float> with_horizontal_limit(const Vector3<float>& v, float limit) {
    const float length = math::norm(v.head<2>());
    if (length <= limit) return v;
    const float part = limit / length;
    return {part * v.x(), part * v.y(), v.z()};
}

}  // namespace

void Motion::reset() {
    integral_.setZero();
    low_passed_velocity_.setConstant(math::canonical_nan<float>());
}

void Motion::set_hover_thrust(float hover_thrust) {
    const float part = limits_.hover_thrust / hover_thrust;
    integral_[kDown] = kGravity - part * (kGravity - integral_[kDown]);
    limits_.hover_thrust = hover_thrust;
}

Vector3<float> Motion::limited_velocity(Vector3<float> velocity) const {
    velocity.z() = math::clamp(velocity.z(), -limits_.climb, limits_.descent);
    return with_horizontal_limit(velocity, limits_.horizontal_speed);
}

// Zero on an axis that is free or unknown.
Vector3<float> Motion::velocity_error(const MotionEstimate& estimate,
                                      const TrajectorySetpoint& setpoint) const {
    const Vector3<float> position = math::vector(setpoint.position);
    const Vector3<float> velocity = math::vector(setpoint.velocity);
    Vector3<float> wanted;
    for (int axis = 0; axis < 3; ++axis) {
        const float position_error = position[axis] - estimate.position_N[axis];
        wanted[axis] = gains_.position_p[axis] * finite_or_zero(position_error) +
                       finite_or_zero(velocity[axis]);
    }
    Vector3<float> error = limited_velocity(wanted) - estimate.velocity_N;
    for (int axis = 0; axis < 3; ++axis) {
        const bool is_free = math::is_nan(position[axis]) && math::is_nan(velocity[axis]);
        error[axis] = is_free ? 0.0F : finite_or_zero(error[axis]);
    }
    return error;
}

Vector3<float> Motion::measured_acceleration(const Vector3<float>& velocity_N, float dt) {
    const float cutoff = gains_.derivative_cutoff;
    const float blend = cutoff * dt / (1.0F + cutoff * dt);
    Vector3<float> acceleration;
    for (int axis = 0; axis < 3; ++axis) {
        float& low = low_passed_velocity_[axis];
        if (!math::is_finite(low)) low = velocity_N[axis];
        low += blend * (velocity_N[axis] - low);
        acceleration[axis] = finite_or_zero(cutoff * (velocity_N[axis] - low));
    }
    return acceleration;
}

Vector3<float> Motion::limited_thrust(Vector3<float> thrust_N, float thrust_max) const {
    const float least = math::min(limits_.thrust_min, thrust_max);
    // Weight goes first, except for what levels a vehicle at the end of its thrust.
    const float leans = math::min(math::norm(thrust_N.head<2>()), limits_.lean_margin * thrust_max);
    const float most = math::sqrt(math::max(math::square(thrust_max) - math::square(leans), 0.0F));
    thrust_N.z() = math::clamp(thrust_N.z(), -most, -least);
    const float left = math::square(thrust_max) - math::square(thrust_N.z());
    const float by_thrust = math::sqrt(math::max(left, 0.0F));
    const float by_tilt = limits_.tan_tilt * -thrust_N.z();
    return with_horizontal_limit(thrust_N, math::min(by_thrust, by_tilt));
}

// Downward acceleration. What carried the weight before may be more than it needs: a height that
// rises shows it.
float Motion::blind_sink(float climb, float dt) {
    constexpr float kP = 1.0F;            // 1/s
    constexpr float kI = 0.3F;            // 1/s^2
    constexpr float kTooMuch = 2.5F;      // m/s^2, more than a load or a battery changes
    constexpr float kFastest_m_s = 3.0F;  // a height that jumps does not count for more
    const float rises = math::clamp(finite_or_zero(climb), 0.0F, kFastest_m_s);
    const float grown = integral_[kDown] + kI * rises * dt;
    integral_[kDown] = math::max(integral_[kDown], math::min(grown, kTooMuch));
    return limits_.blind_sink + kP * rises;
}

Vector3<float> Motion::update(const MotionEstimate& estimate, const TrajectorySetpoint& setpoint,
                              float dt, float thrust_max) {
    const Vector3<float> error = velocity_error(estimate, setpoint);
    const Vector3<float> measured = measured_acceleration(estimate.velocity_N, dt);
    Vector3<float> wanted = gains_.velocity_p.cwiseProduct(error) + integral_ -
                            gains_.velocity_d.cwiseProduct(measured);
    for (int i = 0; i < 3; ++i) {
        const auto axis = static_cast<unsigned>(i);
        wanted[i] += finite_or_zero(setpoint.acceleration[axis]);
        wanted[i] += limits_.drag * finite_or_zero(setpoint.velocity[axis]);
    }
    if (!math::is_finite(estimate.velocity_N[kDown]))
        wanted[kDown] = integral_[kDown] + blind_sink(estimate.climb, dt);

    const float thrust_per_acceleration = limits_.hover_thrust / kGravity;
    const Vector3<float> weight(0.0F, 0.0F, kGravity);
    const Vector3<float> thrust_N =
        limited_thrust(thrust_per_acceleration * (wanted - weight), thrust_max);
    const Vector3<float> cut = wanted - weight - thrust_N / thrust_per_acceleration;
    for (int axis = 0; axis < 3; ++axis) {
        // Far below any acceleration that matters, far above rounding.
        constexpr float kCut = 1e-3F;
        const bool winds_up = math::abs(cut[axis]) > kCut && cut[axis] * error[axis] > 0.0F;
        if (winds_up) continue;
        const float grown = integral_[axis] + gains_.velocity_i[axis] * error[axis] * dt;
        integral_[axis] = math::clamp(grown, -gains_.integral_limit, gains_.integral_limit);
    }
    return thrust_N;
}

}  // namespace stator::apps::position_control
