// Whether an airspeed sensor can be believed.
#pragma once

#include <cstdint>

#include "stator/scalar.hpp"

namespace stator::apps::airspeed_selector {

// A sensor that says the same again and again, nothing, a pressure from behind, or what neither
// the ground speed nor the lift allow. One that was refused in flight stays so.
class AirspeedCheck {
  public:
    // As in AirspeedValidated.faults.
    enum Fault : uint8_t {
        kMissing = 1,
        kStuck = 2,
        kNegative = 4,
        kDisagrees = 8,
        kTooLow = 16,
    };
    struct Limits {
        float innovation;           // m/s
        float innovation_integral;  // m
        float load;
    };
    struct Sample {
        bool is_new;
        float pressure;    // Pa; not a number: none
        float innovation;  // m/s; not a number: nothing to compare with
        float load;        // lift over the most at that airspeed
    };

    void reset() { *this = {}; }
    void update(const Sample& sample, const Limits& limits, float dt) {
        const bool is_there = math::is_finite(sample.pressure);
        silent_s_ = sample.is_new && is_there ? 0.0F : silent_s_ + dt;
        if (silent_s_ >= kSilent_s) faults_ |= kMissing;
        if (sample.is_new && sample.pressure != last_pressure_) same_s_ = 0.0F;
        last_pressure_ = sample.pressure;
        same_s_ += dt;
        if (same_s_ >= kSame_s) faults_ |= kStuck;
        negative_s_ = sample.pressure < kNegativePressure ? negative_s_ + dt : 0.0F;
        if (negative_s_ >= kNegative_s) faults_ |= kNegative;
        const float beyond = math::is_finite(sample.innovation)
                                 ? math::abs(sample.innovation) - limits.innovation
                                 : 0.0F;
        beyond_ = math::max(beyond_ + beyond * dt, 0.0F);
        if (beyond_ >= limits.innovation_integral) faults_ |= kDisagrees;
        const float blend = dt / (kLoadTime_s + dt);
        if (math::is_finite(sample.load)) load_ += blend * (math::min(sample.load, 10.0F) - load_);
        if (load_ > limits.load) faults_ |= kTooLow;
    }
    uint8_t faults() const { return faults_; }

  private:
    static constexpr float kSilent_s = 1.0F;
    static constexpr float kSame_s = 2.0F;
    static constexpr float kNegative_s = 1.0F;
    static constexpr float kNegativePressure = -5.0F;
    static constexpr float kLoadTime_s = 0.5F;

    uint8_t faults_ = 0;
    float silent_s_ = 0.0F;
    float same_s_ = 0.0F;
    float last_pressure_ = 0.0F;
    float negative_s_ = 0.0F;
    float beyond_ = 0.0F;
    float load_ = 0.5F;
};

}  // namespace stator::apps::airspeed_selector
