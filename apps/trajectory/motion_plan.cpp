// Stops, legs and their sum.
#include "motion_plan.hpp"

namespace stator::apps::trajectory {

using math::Vector3;

namespace {

constexpr float kStill = 1e-4F;  // m/s

Vector3<float> unit(float heading) {
    const math::SinCos<float> direction = math::sincos(heading);
    return {direction.cos, direction.sin, 0.0F};
}

}  // namespace

Stop::Stop(const PathState& start, const ProfileLimits& limits) : start_(start) {
    fade_time_ = math::norm(start.acceleration) / limits.jerk;
    velocity_ = start.velocity + 0.5F * fade_time_ * start.acceleration;
    const float speed = math::norm(velocity_);
    if (speed > kStill) {
        direction_ = velocity_ / speed;
        speed_up_ = SpeedUp({speed, limits.acceleration, limits.jerk});
    }
    duration_ = math::max(fade_time_, speed_up_.duration());
}

PathState Stop::at(float time) const {
    const float t = math::clamp(time, 0.0F, duration_);
    const float fading = math::min(t, fade_time_);
    const float left = fade_time_ > 0.0F ? 1.0F - fading / fade_time_ : 0.0F;
    const Vector3<float>& a = start_.acceleration;
    const Vector3<float> gained = a * (0.5F * fading * (1.0F + left));
    const Vector3<float> moved =
        a * (fading * fading * (2.0F + left) / 6.0F) + gained * (t - fading);
    const Along taken = speed_up_.at(t);
    const bool is_over = t >= duration_;
    PathState state;
    state.position = start_.position + start_.velocity * t + moved - direction_ * taken.distance;
    if (is_over) return state;
    state.velocity = start_.velocity + gained - direction_ * taken.speed;
    state.acceleration = a * left - direction_ * taken.acceleration;
    return state;
}

Leg Leg::line(const Vector3<float>& way, const ProfileLimits& limits) {
    Leg leg;
    leg.axis_ = math::normalized(way);
    leg.profile_ = Profile(math::norm(way), limits);
    return leg;
}

// r (cos p - 1) along the axis and r sin p across: clockwise for p above 0.
Leg Leg::circle(float bearing, float radius, float turns, const ProfileLimits& limits) {
    Leg leg;
    leg.radius_ = radius;
    leg.axis_ = unit(bearing);
    leg.across_ =
        unit(turns < 0.0F ? bearing - math::kHalfPi<float> : bearing + math::kHalfPi<float>);
    // The acceleration inwards, too, stays within the limit.
    const float speed = math::min(limits.speed, math::sqrt(limits.acceleration * radius));
    leg.profile_ = Profile(math::kTwoPi<float> * math::abs(turns),
                           {speed / radius, limits.acceleration / radius, limits.jerk / radius});
    return leg;
}

// In the middle the speed is sqrt(2) A p': the limits are those of p.
Leg Leg::eight(float heading, float length, float laps, const ProfileLimits& limits) {
    Leg leg;
    leg.half_length_ = 0.5F * length;
    leg.axis_ = unit(heading);
    leg.across_ = unit(heading + math::kHalfPi<float>);
    const float per_phase = 0x1.6a09e6p+0F * leg.half_length_;
    leg.profile_ = Profile(
        math::kTwoPi<float> * laps,
        {limits.speed / per_phase, limits.acceleration / per_phase, limits.jerk / per_phase});
    return leg;
}

PathState Leg::at(float time) const {
    const Along along = profile_.at(time);
    if (radius_ != 0.0F) {
        const math::SinCos<float> phase = math::sincos(along.distance);
        const Vector3<float> out = radius_ * (phase.cos * axis_ + phase.sin * across_);
        const Vector3<float> tangent = radius_ * (phase.cos * across_ - phase.sin * axis_);
        return {out - radius_ * axis_, along.speed * tangent,
                along.acceleration * tangent - math::square(along.speed) * out};
    }
    if (half_length_ == 0.0F) {
        return {axis_ * along.distance, axis_ * along.speed, axis_ * along.acceleration};
    }
    const math::SinCos<float> once = math::sincos(along.distance);
    const math::SinCos<float> twice = math::sincos(2.0F * along.distance);
    const Vector3<float> long_way = half_length_ * axis_;
    const Vector3<float> wide_way = half_length_ * across_;
    const Vector3<float> tangent = once.cos * long_way + twice.cos * wide_way;
    const Vector3<float> bend = -once.sin * long_way - 2.0F * twice.sin * wide_way;
    return {once.sin * long_way + 0.5F * twice.sin * wide_way, along.speed * tangent,
            along.acceleration * tangent + math::square(along.speed) * bend};
}

MotionPlan::MotionPlan(const Stop& stop, const Leg& leg) : stop_(stop), leg_(leg) {
    const float midway = 0.5F * leg.duration();
    const bool leads_back = leg.at(midway).velocity.dot(stop.velocity()) < 0.0F;
    if (leads_back) leg_start_ = stop.duration();
}

float MotionPlan::duration() const {
    return math::max(stop_.duration(), leg_start_ + leg_.duration());
}

PathState MotionPlan::at(float time) const {
    const PathState stopping = stop_.at(time);
    const PathState going = leg_.at(time - leg_start_);
    return {stopping.position + going.position, stopping.velocity + going.velocity,
            stopping.acceleration + going.acceleration};
}

}  // namespace stator::apps::trajectory
