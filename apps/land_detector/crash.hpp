// Whether the vehicle lies on the ground, upside down or on its side.
#pragma once

#include "stator/rotation.hpp"

namespace stator::apps::land_detector {

// Thrust acts along -z of B, and what lies on the ground feels gravity alone, wherever its rotors
// push: so the specific force then has no part along -z, in the air it has nothing else. What
// tumbles turns fast, each moment about another axis: a slow steady rate is the gyro's error. Where
// the estimated attitude does not agree, it takes longer: what turned so fast that the gyro could
// not follow does not know how it lies.
class Crash {
  public:
    // The newest samples; a tilt in rad.
    bool update(const math::Vector3<float>& force_B, const math::Vector3<float>& rate_B,
                float cos_tilt, float dt) {
        const float blend = dt / (kSmoothing_s + dt);
        force_B_ += blend * (force_B - force_B_);
        steady_rate_B_ += (rate_B - steady_rate_B_) * (dt / (kSteady_s + dt));
        const float felt = math::norm(force_B_);
        const bool may_be_error = math::norm(steady_rate_B_) < kGyroError;
        const bool turns = math::norm(rate_B) >= kTumbling &&
                           !(may_be_error && math::norm(rate_B - steady_rate_B_) < kTumbling);
        const bool rests = math::abs(felt - kGravity) < 0.4F * kGravity && !turns;
        const bool lies = rests && force_B_.z() > -kFallen * kGravity;
        inverted_s_ = cos_tilt < 0.0F ? inverted_s_ + dt : 0.0F;
        whirls_s_ = math::norm(rate_B) > kWhirls ? whirls_s_ + dt : 0.0F;
        if (watch_frozen(force_B, rate_B, dt) || inverted_s_ >= kInverted_s ||
            whirls_s_ >= kWhirls_s)
            return true;
        for_s_ = lies ? math::min(for_s_ + dt, kAlone_s) : 0.0F;
        const bool looks_fallen = cos_tilt < kFallen;
        const bool is_quiet = looks_fallen && math::norm(rate_B) < kQuiet;
        quiet_for_s_ = is_quiet ? math::min(quiet_for_s_ + dt, kQuiet_s) : 0.0F;
        return for_s_ >= (looks_fallen ? kLasts_s : kAlone_s) || quiet_for_s_ >= kQuiet_s;
    }
    void reset() {
        for_s_ = quiet_for_s_ = inverted_s_ = whirls_s_ = 0.0F;
        frozen_s_ = gyro_frozen_s_ = clips_for_s_ = tumbled_s_ = lain_s_ = dead_s_ = 0.0F;
    }

  private:
    // An accelerometer at the end of its range repeats itself and says nothing. Then what tumbled
    // and now turns no more lies on the ground. A gyro at the end of its range repeats itself, too,
    // while it tumbles. Where all axes of both repeat themselves, nothing has kept it in the air.
    bool watch_frozen(const math::Vector3<float>& force_B, const math::Vector3<float>& rate_B,
                      float dt) {
        const math::Vector3<float> change_B = (force_B - felt_B_).cwiseAbs();
        const math::Vector3<float> turn_B = (rate_B - last_rate_B_).cwiseAbs();
        const bool is_dead = change_B.maxCoeff() == 0.0F && turn_B.maxCoeff() == 0.0F;
        felt_B_ = force_B;
        last_rate_B_ = rate_B;
        dead_s_ = is_dead ? dead_s_ + dt : 0.0F;
        frozen_s_ = change_B.minCoeff() == 0.0F ? frozen_s_ + dt : 0.0F;
        if (frozen_s_ >= kFrozen_s) clips_for_s_ = kClips_s;
        clips_for_s_ = math::max(clips_for_s_ - dt, 0.0F);
        const float rate = math::norm(rate_B);
        gyro_frozen_s_ = turn_B.minCoeff() == 0.0F ? gyro_frozen_s_ + dt : 0.0F;
        const bool turns = rate > kTurns || gyro_frozen_s_ >= kGyroFrozen_s;
        if (clips_for_s_ == 0.0F) tumbled_s_ = lain_s_ = 0.0F;
        if (clips_for_s_ > 0.0F && turns) tumbled_s_ += dt;
        lain_s_ = tumbled_s_ >= kTumbled_s && rate < kQuiet ? lain_s_ + dt : 0.0F;
        return lain_s_ >= kQuiet_s || dead_s_ >= kDead_s;
    }

    static constexpr float kGravity = 9.80665F;
    static constexpr float kFallen = 0.5F;       // the cosine of 60 deg
    static constexpr float kTumbling = 1.5F;     // rad/s
    static constexpr float kSmoothing_s = 0.1F;  // against vibration
    static constexpr float kSteady_s = 1.0F;
    static constexpr float kGyroError = 3.0F;  // rad/s
    static constexpr float kLasts_s = 0.7F;
    static constexpr float kAlone_s = 3.0F;
    // Nothing that flies leans so far and does not turn: whatever the accelerometer says.
    static constexpr float kQuiet = 0.3F;  // rad/s
    static constexpr float kQuiet_s = 1.5F;
    static constexpr float kInverted_s = 4.0F;
    static constexpr float kWhirls = 25.0F;  // rad/s, half as much again as a lost motor causes
    static constexpr float kWhirls_s = 1.0F;
    static constexpr float kFrozen_s = 0.2F;
    static constexpr float kGyroFrozen_s = 0.1F;
    static constexpr float kClips_s = 3.0F;
    static constexpr float kDead_s = 2.0F;
    static constexpr float kTurns = 0.6F;  // rad/s: a gyro at the end of its range shows no more
    static constexpr float kTumbled_s = 0.4F;

    math::Vector3<float> force_B_ = {0.0F, 0.0F, -kGravity};
    math::Vector3<float> steady_rate_B_ = math::Vector3<float>::Zero();
    math::Vector3<float> felt_B_ = math::Vector3<float>::Zero();
    math::Vector3<float> last_rate_B_ = math::Vector3<float>::Zero();
    float dead_s_ = 0.0F;
    float inverted_s_ = 0.0F;
    float whirls_s_ = 0.0F;
    float clips_for_s_ = 0.0F;
    float frozen_s_ = 0.0F;
    float gyro_frozen_s_ = 0.0F;
    float tumbled_s_ = 0.0F;
    float lain_s_ = 0.0F;
    float for_s_ = 0.0F;
    float quiet_for_s_ = 0.0F;
};

}  // namespace stator::apps::land_detector
