// Whether the vehicle lies on the ground, upside down or on its side.
#pragma once

#include "stator/rotation.hpp"

namespace stator::apps::land_detector {

// Thrust acts along -z of B, and what lies on the ground feels gravity alone, wherever its rotors
// push: so the specific force then has no part along -z, in the air it has nothing else. What
// tumbles turns fast. Where the estimated attitude does not agree, it takes longer: what turned so
// fast that the gyro could not follow does not know how it lies.
class Crash {
  public:
    // The newest samples; a tilt in rad.
    bool update(const math::Vector3<float>& force_B, const math::Vector3<float>& rate_B,
                float cos_tilt, float dt) {
        const float blend = dt / (kSmoothing_s + dt);
        force_B_ += blend * (force_B - force_B_);
        const float felt = math::norm(force_B_);
        const bool rests =
            math::abs(felt - kGravity) < 0.4F * kGravity && math::norm(rate_B) < kTumbling;
        const bool lies = rests && force_B_.z() > -kFallen * kGravity;
        for_s_ = lies ? math::min(for_s_ + dt, kAlone_s) : 0.0F;
        const bool looks_fallen = cos_tilt < kFallen;
        const bool is_quiet = looks_fallen && math::norm(rate_B) < kQuiet;
        quiet_for_s_ = is_quiet ? math::min(quiet_for_s_ + dt, kQuiet_s) : 0.0F;
        return for_s_ >= (looks_fallen ? kLasts_s : kAlone_s) || quiet_for_s_ >= kQuiet_s;
    }
    void reset() { for_s_ = quiet_for_s_ = 0.0F; }

  private:
    static constexpr float kGravity = 9.80665F;
    static constexpr float kFallen = 0.5F;       // the cosine of 60 deg
    static constexpr float kTumbling = 1.5F;     // rad/s
    static constexpr float kSmoothing_s = 0.1F;  // against vibration
    static constexpr float kLasts_s = 0.7F;
    static constexpr float kAlone_s = 3.0F;
    // Nothing that flies leans so far and does not turn: whatever the accelerometer says.
    static constexpr float kQuiet = 0.3F;  // rad/s
    static constexpr float kQuiet_s = 1.5F;

    math::Vector3<float> force_B_ = {0.0F, 0.0F, -kGravity};
    float for_s_ = 0.0F;
    float quiet_for_s_ = 0.0F;
};

}  // namespace stator::apps::land_detector
