// Double-S profiles.
#include "profile.hpp"

#include "stator/scalar.hpp"

namespace stator::apps::trajectory {

namespace {

// Shorter ways take no time.
constexpr float kShortest = 1e-4F;

// The fastest speed from which a line of this length still leaves room to brake.
float fastest(float length, const ProfileLimits& limits) {
    const float a = limits.acceleration;
    const float j = limits.jerk;
    if (length >= 2.0F * a * a * a / (j * j)) {  // the acceleration reaches its limit
        const float half = 0.5F * a / j;
        const float duration = half + math::sqrt(half * half + length / a);
        return a * (duration - a / j);
    }
    const float jerk_time = math::pow(0.5F * length / j, 1.0F / 3.0F);
    return j * jerk_time * jerk_time;
}

}  // namespace

SpeedUp::SpeedUp(const ProfileLimits& limits) : speed_(limits.speed), jerk_(limits.jerk) {
    const float jerk_time = limits.acceleration / jerk_;
    const bool reaches_limit = speed_ >= limits.acceleration * jerk_time;
    jerk_time_ = reaches_limit ? jerk_time : math::sqrt(speed_ / jerk_);
    duration_ = reaches_limit ? jerk_time_ + speed_ / limits.acceleration : 2.0F * jerk_time_;
}

Along SpeedUp::at(float time) const {
    if (time < jerk_time_) {
        return {jerk_ * time * time * time / 6.0F, 0.5F * jerk_ * time * time, jerk_ * time};
    }
    const float acceleration = jerk_ * jerk_time_;
    if (time < duration_ - jerk_time_) {
        const float distance =
            (time * (time - jerk_time_) / 2.0F + jerk_time_ * jerk_time_ / 6.0F) * acceleration;
        return {distance, acceleration * (time - 0.5F * jerk_time_), acceleration};
    }
    const float left = math::max(duration_ - time, 0.0F);
    const float behind = speed_ * (time - 0.5F * duration_);  // as if at full speed from the middle
    return {behind + jerk_ * left * left * left / 6.0F, speed_ - 0.5F * jerk_ * left * left,
            jerk_ * left};
}

Profile::Profile(float length, const ProfileLimits& limits) {
    if (length < kShortest) return;
    length_ = length;
    ProfileLimits reached = limits;
    reached.speed = math::min(limits.speed, fastest(length, limits));
    speed_up_ = SpeedUp(reached);
    duration_ = length / reached.speed + speed_up_.duration();
}

Along Profile::at(float time) const {
    const float t = math::clamp(time, 0.0F, duration_);
    if (t <= 0.5F * duration_) return speed_up_.at(t);
    const Along mirrored = speed_up_.at(duration_ - t);
    return {length_ - mirrored.distance, mirrored.speed, -mirrored.acceleration};
}

}  // namespace stator::apps::trajectory
