// Finds level from gravity before the filter starts.
#pragma once

#include "filter.hpp"

namespace stator::apps::navigation {

class Alignment {
  public:
    // Adds a sample. True once there are enough; then start() may be called.
    [[nodiscard]] bool add(const Vector& force_B, float time) {
        force_B_ += force_B * time;
        time_ += time;
        return time_ >= kTime && force_B_.squaredNorm() > 0.0F;
    }
    // Heading zero.
    Quaternion attitude() const {
        const Vector down_B = math::normalized(Vector(-force_B_));
        const float roll = math::atan2(down_B.y(), down_B.z());
        const float level = math::norm(down_B.tail<2>());
        const float pitch = math::atan2(-down_B.x(), level);
        return math::from_euler(math::EulerAngles<float>{roll, pitch, 0.0F});
    }
    // Of each tilt angle. A vehicle that banks by phi in a turn feels 1 / cos phi of gravity and
    // takes that direction for down: phi^2 is twice the excess.
    float tilt_variance() const {
        constexpr float kAtRest = 0.02F;     // rad: the ground shakes, a hand holds it
        constexpr float kTolerance = 0.02F;  // of the accelerometer's scale
        const float excess = math::abs(math::norm(force_B_) / (time_ * kGravity) - 1.0F);
        return math::square(kAtRest) + 2.0F * math::max(excess - kTolerance, 0.0F);
    }

  private:
    static constexpr float kTime = 0.3F;  // s

    Vector force_B_ = Vector::Zero();
    float time_ = 0.0F;
};

}  // namespace stator::apps::navigation
