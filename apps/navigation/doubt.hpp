// Whether the accelerometer can be right.
#pragma once

#include "motion.hpp"

namespace stator::apps::navigation {

// Two things speak against it. In flight the motors' commands say what it should feel: the ratio of
// the two is learned, and a force that lacks most of the thrust's share for longer than rotors need
// to spin up is not felt by the vehicle. (More force than thrust explains is the ground, or a
// gust.) And sensors that do not use it may agree that the inertial solution is wrong: agreed();
// or what it seems to be wrong by is more than any accelerometer's bias: refuted().
// While in doubt, velocity and height are not valid, and the filter takes what others measure.
class Doubt {
  public:
    // In flight. The sum of the motors' commands; force along -z of B.
    void update(float command, float lift, float dt) {
        thrust_ += (command - thrust_) * dt / (kRotorLag_s + dt);
        lift_ += (lift - lift_) * dt / (kShake_s + dt);
        const bool lacks = learned_s_ >= kKnows_s &&
                           ratio_ * thrust_ - lift_ > math::max(kLacks, kShare * ratio_ * thrust_);
        lacks_for_s_ = lacks ? math::min(lacks_for_s_ + dt, kLasts_s) : 0.0F;
        const bool goes_on = now() && math::abs(ratio_ * thrust_ - lift_) > kDiffers;
        if (lacks_for_s_ >= kLasts_s || goes_on) agreed();
        left_s_ = math::max(left_s_ - dt, 0.0F);
        if (lacks || now() || thrust_ < kTells) return;
        learned_s_ = math::min(learned_s_ + dt, kLearns_s);
        ratio_ += (lift_ / thrust_ - ratio_) * dt / learned_s_;
    }
    void agreed() { left_s_ = math::max(left_s_, kClears_s); }
    void refuted() { left_s_ = kRefuted_s; }
    void reset() { *this = Doubt(); }

    bool now() const { return left_s_ > 0.0F; }
    // Force that the commands explain, in B.
    Vector expected() const { return {0.0F, 0.0F, -ratio_ * thrust_}; }

  private:
    static constexpr float kRotorLag_s = 0.03F;
    static constexpr float kShake_s = 0.02F;
    static constexpr float kTells = 0.8F;    // less thrust says little
    static constexpr float kLacks = 5.0F;    // m/s^2
    static constexpr float kShare = 0.65F;   // a storm through tilted rotors takes half of it
    static constexpr float kDiffers = 2.5F;  // m/s^2, of an accelerometer that is still wrong
    static constexpr float kLasts_s = 0.04F;
    static constexpr float kLearns_s = 5.0F;  // a battery sags more slowly
    static constexpr float kKnows_s = 1.0F;
    // Two satellite fixes, and the time that they need to arrive.
    static constexpr float kClears_s = 0.45F;
    static constexpr float kRefuted_s = 3.0F;

    float thrust_ = 0.0F;
    float lift_ = 0.0F;
    float ratio_ = 0.0F;  // m/s^2
    float learned_s_ = 0.0F;
    float lacks_for_s_ = 0.0F;
    float left_s_ = 0.0F;
};

}  // namespace stator::apps::navigation
