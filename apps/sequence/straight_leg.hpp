// Motion along a straight line from rest to rest, with limited speed and acceleration.
#pragma once

#include "stator/rotation.hpp"

namespace stator::apps::sequence {

// The speed rises at the acceleration, is capped, and falls so that after each step of dt the rest
// is just enough to brake: speed * dt + speed^2 / (2 * acceleration) = rest.
class StraightLeg {
  public:
    StraightLeg() = default;
    // `direction` of unit length, `length` >= 0.
    StraightLeg(const math::Vector3<float>& start, const math::Vector3<float>& direction,
                float length)
        : start_(start), direction_(direction), length_(length) {}
    static StraightLeg between(const math::Vector3<float>& start, const math::Vector3<float>& end) {
        const math::Vector3<float> way = end - start;
        return {start, math::normalized(way), math::norm(way)};
    }

    void advance(float speed_limit, float acceleration_limit, float dt) {
        const float rest = length_ - distance_;
        const float step = acceleration_limit * dt;
        const float braking = math::sqrt(step * step + 2.0F * acceleration_limit * rest) - step;
        const float faster = speed_ + step;
        const float speed = math::min(faster, math::min(speed_limit, braking));
        const float change = (speed - speed_) / dt;
        acceleration_ = math::clamp(change, -acceleration_limit, acceleration_limit);
        speed_ = speed;
        distance_ += speed * dt;
        if (length_ - distance_ < kArrived) distance_ = length_;
    }

    bool is_at_rest() const { return distance_ >= length_ && speed_ == 0.0F; }
    math::Vector3<float> position() const { return start_ + distance_ * direction_; }
    math::Vector3<float> velocity() const { return speed_ * direction_; }
    math::Vector3<float> acceleration() const { return acceleration_ * direction_; }

  private:
    static constexpr float kArrived = 1e-4F;  // m

    math::Vector3<float> start_ = math::Vector3<float>::Zero();
    math::Vector3<float> direction_ = math::Vector3<float>::Zero();
    float length_ = 0.0F;
    float distance_ = 0.0F;
    float speed_ = 0.0F;
    float acceleration_ = 0.0F;
};

}  // namespace stator::apps::sequence
