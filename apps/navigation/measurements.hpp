// Measurements on their way to the filter's horizon.
#pragma once

#include <array>
#include <cstdint>

#include "motion.hpp"

namespace stator::apps::navigation {

struct GnssMeasurement {
    uint64_t time_us = 0;
    Vector velocity_N = Vector::Zero();
    Vector position_N = Vector::Zero();  // down: 0
    double height = 0.0;                 // m, above mean sea level
    float velocity_variance = 0.0F;
    float position_variance = 0.0F;
    float height_variance = 0.0F;
    bool has_velocity = false;
    bool has_height = false;
};

// Of a receiver whose velocity and positions differ by this, squared: either may be wrong.
inline float inconsistency_variance(float squared) {
    constexpr float kShare = 0.7F;
    constexpr float kUsual = 0.8F;  // m/s, by the noise of its positions
    return math::square(kShare) * math::max(squared - math::square(kUsual), 0.0F);
}

struct BaroMeasurement {
    uint64_t time_us = 0;
    float height = 0.0F;  // m, in the standard atmosphere
};

struct MagMeasurement {
    uint64_t time_us = 0;
    Vector field_B = Vector::Zero();
};

// Measurements of one kind that wait until the filter's horizon reaches their time. First in, first
// out.
template <class Measurement, unsigned kCapacity>
class DelayedMeasurements {
  public:
    bool empty() const { return count_ == 0; }
    const Measurement& front() const { return items_[first_]; }
    void pop() {
        first_ = (first_ + 1) % kCapacity;
        --count_;
    }
    // False if there is no room, or it is not newer than the one before.
    [[nodiscard]] bool push(const Measurement& item) {
        if (count_ == kCapacity || item.time_us <= newest_us_) return false;
        items_[(first_ + count_) % kCapacity] = item;
        newest_us_ = item.time_us;
        ++count_;
        return true;
    }
    uint64_t newest_us() const { return newest_us_; }

  private:
    std::array<Measurement, kCapacity> items_{};
    uint64_t newest_us_ = 0;
    unsigned first_ = 0;
    unsigned count_ = 0;
};

// How fast the barometer's height changes: the slope of a line through its last samples.
class BaroRate {
  public:
    void add(uint64_t time_us, float height) {
        if (time_us <= newest_us_ || time_us - newest_us_ > kLongestGap_us) count_ = 0;
        newest_us_ = time_us;
        if (count_ == kSamples) {
            for (unsigned i = 1; i < kSamples; ++i) samples_[i - 1] = samples_[i];
            --count_;
        }
        samples_[count_++] = {time_us, height};
    }
    bool known(uint64_t now_us) const {
        return count_ == kSamples && now_us < newest_us_ + kOld_us;
    }
    // Up, m/s, in the middle of the last samples.
    float value() const {
        float t = 0.0F, h = 0.0F, tt = 0.0F, th = 0.0F;
        for (const Sample& sample : samples_) {
            const float time = static_cast<float>(sample.time_us - samples_[0].time_us) * 1e-6F;
            const float height = sample.height - samples_[0].height;
            t += time;
            h += height;
            tt += time * time;
            th += time * height;
        }
        constexpr auto kN = static_cast<float>(kSamples);
        return (kN * th - t * h) / (kN * tt - t * t);
    }

  private:
    static constexpr unsigned kSamples = 8;  // 0.3 s
    static constexpr uint64_t kLongestGap_us = 200'000;
    static constexpr uint64_t kOld_us = 1'000'000;
    struct Sample {
        uint64_t time_us = 0;
        float height = 0.0F;
    };
    std::array<Sample, kSamples> samples_{};
    uint64_t newest_us_ = 0;
    unsigned count_ = 0;
};

// One sample that is far from those before and after it is not what was measured.
class Spike {
  public:
    explicit Spike(float fastest) : fastest_(fastest) {}  // change, per s
    // The sample, or the one before in its place; a second one that is as far away is true.
    Vector without(const Vector& sample, float dt) {
        const bool is_far = (sample - last_).cwiseAbs().maxCoeff() > fastest_ * dt;
        if (!is_far || was_far_) last_ = sample;
        was_far_ = is_far && !was_far_;
        return last_;
    }

  private:
    float fastest_;
    Vector last_ = Vector::Zero();
    bool was_far_ = false;
};

// Whether a sensor gives the same sample again and again: a live one has noise.
class Frozen {
  public:
    // Of one sample, any number that changes with each of its values. True after `most` equal ones.
    bool update(float value, unsigned most) {
        count_ = value == value_ ? (count_ < most ? count_ + 1 : most) : 0;
        value_ = value;
        return count_ >= most;
    }

  private:
    float value_ = 0.0F;
    unsigned count_ = 0;
};

// Whether a kind of measurement is believed.
class Aid {
  public:
    bool started() const { return started_; }
    uint64_t last_us() const { return last_us_; }
    bool recent(uint64_t now_us, float seconds) const {
        // A newer measurement of another kind may have come before.
        const uint64_t age_us = now_us > last_us_ ? now_us - last_us_ : 0;
        return started_ && static_cast<float>(age_us) * 1e-6F <= seconds;
    }
    // Notes how a measurement went. True if it should be believed all the same: it is the first,
    // or all were left out for `timeout` seconds.
    [[nodiscard]] bool note(bool fused, uint64_t time_us, float timeout) {
        if (fused) {
            accept(time_us);
            return false;
        }
        if (!refusing_) refused_us_ = time_us;
        refusing_ = true;
        return static_cast<float>(time_us - refused_us_) * 1e-6F > timeout;
    }
    // For how long all were left out.
    float refused_for(uint64_t now_us) const {
        if (!refusing_ || now_us < refused_us_) return 0.0F;
        return static_cast<float>(now_us - refused_us_) * 1e-6F;
    }
    void accept(uint64_t time_us) {
        started_ = true;
        refusing_ = false;
        last_us_ = time_us;
    }

  private:
    uint64_t last_us_ = 0;
    uint64_t refused_us_ = 0;
    bool started_ = false;
    bool refusing_ = false;
};

}  // namespace stator::apps::navigation
