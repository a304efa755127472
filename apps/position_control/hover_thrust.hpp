// The thrust that carries the weight, learned in flight: it changes with load and battery.
#pragma once

#include "stator/scalar.hpp"

namespace stator::apps::position_control {

//     v' = g * (1 - thrust / hover)     v downwards, thrust upwards
//
// The innovation, what the velocity changed by less what it should have, corrects `hover`, slowly
// against gusts and the lag of the motors.
class HoverThrust {
  public:
    void restart(float guess) {
        hover_ = guess;
        guess_ = guess;
        has_velocity_ = false;
    }
    float value() const { return hover_; }

    // `thrust` since the update before, `velocity` now; a velocity that is not a number, or dt = 0,
    // changes nothing.
    void update(float thrust, float velocity, float dt, float time_constant) {
        constexpr float kGravity = 9.80665F;
        // No load or battery changes it by more than this.
        constexpr float kMin = 0.6F;
        constexpr float kMax = 1.6F;
        const float expected = kGravity * (1.0F - thrust / hover_) * dt;
        const float innovation = velocity - velocity_ - expected;
        const bool is_usable = has_velocity_ && math::is_finite(innovation);
        has_velocity_ = math::is_finite(velocity);
        velocity_ = velocity;
        if (!is_usable) return;
        const float corrected = hover_ + hover_ / (kGravity * time_constant) * innovation;
        hover_ = math::clamp(corrected, kMin * guess_, kMax * guess_);
    }

  private:
    float hover_ = 0.5F;
    float guess_ = 0.5F;
    float velocity_ = 0.0F;
    bool has_velocity_ = false;
};

}  // namespace stator::apps::position_control
