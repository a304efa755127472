// Whether the accelerometer can be right.
#pragma once

#include "motion.hpp"

namespace stator::apps::navigation {

// Two things speak against it. In flight the motors' commands say what it should feel: the ratio of
// the two is learned, and a force that lacks most of the thrust's share for longer than rotors need
// to spin up is not felt by the vehicle. (More force than thrust explains is the ground, or a
// gust.) And sensors that do not use it may agree that the inertial solution is wrong: agreed();
// or what it seems to be wrong by is more than any accelerometer's bias: refuted().
// While in doubt, the filter takes what others measure, and what commands and wind explain takes
// the place of what is felt. The ratio may have been learned from an accelerometer that was wrong
// already: so vertical innovations correct it, and while they stay small the doubt is settled. A
// vertical velocity is valid without doubt, or once it is settled.
class Doubt {
  public:
    // In flight. The sum of the motors' commands; force in B.
    void update(float command, const Vector& force_B, float dt) {
        thrust_ += (command - thrust_) * dt / (kRotorLag_s + dt);
        lift_ += (-force_B.z() - lift_) * dt / (kShake_s + dt);
        sideways_B_ += (force_B.head<2>() - sideways_B_) * (dt / (kSideways_s + dt));
        const float explained = ratio_ * thrust_;
        const bool lacks = knows() && explained - lift_ > math::max(kLacks, kShare * explained);
        lacks_for_s_ = lacks ? math::min(lacks_for_s_ + dt, kLasts_s) : 0.0F;
        const bool is_wrong = math::abs(explained - lift_) > kDiffers ||
                              sideways_B_.squaredNorm() > math::square(kSideways);
        if (lacks_for_s_ >= kLasts_s || (now() && is_wrong)) agreed();
        left_s_ = math::max(left_s_ - dt, 0.0F);
        if (!now()) settled_for_s_ = 0.0F;
        if (lacks || now() || thrust_ < kTells) return;
        learned_s_ = math::min(learned_s_ + dt, kLearns_s);
        ratio_ += (lift_ / thrust_ - ratio_) * dt / learned_s_;
    }
    // The wind's push is the same for a while in N, however the vehicle turns.
    void follow_wind(const Quaternion& q_NB, float dt) {
        const Vector felt_N = q_NB * Vector(sideways_B_.x(), sideways_B_.y(), 0.0F);
        if (!now()) wind_N_ += (felt_N.head<2>() - wind_N_) * (dt / (kWind_s + dt));
        wind_B_ = q_NB.conjugate() * Vector(wind_N_.x(), wind_N_.y(), 0.0F);
    }
    // What a vertical velocity of others differs by from the estimate: of satellites, each fix.
    void correct(float down, float dt) {
        const float part = math::clamp(down, -kMostInnovation, kMostInnovation);
        innovation_ += (down - innovation_) * (dt / (kSettles_s + dt));
        if (!now()) return;
        settled_for_s_ = math::abs(innovation_) < kSmall ? settled_for_s_ + dt : 0.0F;
        if (knows() && thrust_ >= kTells)
            ratio_ = math::max(ratio_ - part / (kCorrects_s * thrust_), 0.0F);
    }
    void agreed() { left_s_ = math::max(left_s_, kClears_s); }
    void refuted() {
        left_s_ = kRefuted_s;
        wind_N_.setZero();  // it was learned from what is wrong
    }
    void reset() { *this = Doubt(); }

    bool now() const { return left_s_ > 0.0F; }
    bool settled() const { return settled_for_s_ >= kSettles_s; }
    // What the force may be wrong by.
    float force_error() const { return !now() ? 0.0F : settled() ? kSettledForce : kForce; }
    // Force that commands and wind explain, in B.
    Vector expected() const {
        return {wind_B_.x(), wind_B_.y(), knows() ? -ratio_ * thrust_ : -kGravity};
    }

  private:
    bool knows() const { return learned_s_ >= kKnows_s; }

    static constexpr float kGravity = 9.80665F;
    static constexpr float kRotorLag_s = 0.03F;
    static constexpr float kShake_s = 0.02F;
    static constexpr float kTells = 0.8F;     // less thrust says little
    static constexpr float kLacks = 5.0F;     // m/s^2
    static constexpr float kShare = 0.65F;    // a storm through tilted rotors takes half of it
    static constexpr float kDiffers = 2.5F;   // m/s^2, of an accelerometer that is still wrong
    static constexpr float kSideways = 6.0F;  // m/s^2, more than wind pushes
    static constexpr float kSideways_s = 0.3F;
    static constexpr float kWind_s = 10.0F;
    static constexpr float kLasts_s = 0.04F;
    static constexpr float kLearns_s = 5.0F;  // a battery sags more slowly
    static constexpr float kKnows_s = 1.0F;
    // Two satellite fixes, and the time that they need to arrive.
    static constexpr float kClears_s = 0.45F;
    static constexpr float kRefuted_s = 3.0F;
    static constexpr float kCorrects_s = 1.5F;      // slow against the delay of fixes
    static constexpr float kMostInnovation = 2.0F;  // m/s
    static constexpr float kSmall = 0.7F;           // m/s, innovations of a force that fits
    static constexpr float kSettles_s = 1.5F;
    static constexpr float kForce = 10.0F;        // m/s^2
    static constexpr float kSettledForce = 4.0F;  // m/s^2

    float thrust_ = 0.0F;
    float lift_ = 0.0F;
    float ratio_ = 0.0F;  // m/s^2
    Eigen::Vector2f sideways_B_ = Eigen::Vector2f::Zero();
    Eigen::Vector2f wind_N_ = Eigen::Vector2f::Zero();
    Vector wind_B_ = Vector::Zero();
    float innovation_ = 0.0F;  // m/s, low-passed
    float settled_for_s_ = 0.0F;
    float learned_s_ = 0.0F;
    float lacks_for_s_ = 0.0F;
    float left_s_ = 0.0F;
};

}  // namespace stator::apps::navigation
