// Averages, and low-pass filters whose steps need not be equal: the samples' own times say how long
// each was.
#pragma once

#include "stator/rotation.hpp"

namespace stator::apps::attitude {

// How far to move towards each sample, for a first-order low-pass. The first samples, up to the
// time constant, are averaged instead, so that there is no initial value to forget.
class FollowGain {
  public:
    // 0 to 1, for a sample `dt` after the one before. One of less `trust` counts for less, except
    // while there is nothing better.
    float next(float dt, float time_constant, float trust = 1.0F) {
        filled_ += dt;
        if (filled_ <= 0.0F) return 1.0F;
        const float follow = trust * dt / (time_constant + dt);
        return filled_ < time_constant ? math::max(dt / filled_, follow) : follow;
    }
    void restart() { filled_ = 0.0F; }

  private:
    float filled_ = 0.0F;
};

// Mean of what was added since it was taken last.
class Average {
  public:
    using Vector = math::Vector3<float>;

    void add(const Vector& sample) {
        sum_ += sample;
        count_ += 1.0F;
    }
    Vector take() {
        const Vector mean = count_ > 0.0F ? Vector(sum_ * (1.0F / count_)) : sum_;
        *this = Average();
        return mean;
    }

  private:
    Vector sum_ = Vector::Zero();
    float count_ = 0.0F;
};

// Second-order Butterworth of vectors, with the delay `time_constant` at low frequencies:
//     y'' = w^2 (u - y) - sqrt(2) w y',  w = sqrt(2) / time_constant,
// by implicit Euler steps, which are stable however long. Begins with the mean, as above.
template <class Vector>
class LowPass {
  public:
    void update(const Vector& sample, float dt, float time_constant) {
        filled_ += dt;
        if (filled_ < time_constant) {
            value_ += (sample - value_) * (filled_ > 0.0F ? dt / filled_ : 1.0F);
            return;
        }
        const float x = dt / time_constant;
        const float inverse = 1.0F / (1.0F + 2.0F * x * (1.0F + x));
        rate_ = (rate_ + (sample - value_) * (2.0F * x / time_constant)) * inverse;
        value_ += rate_ * dt;
    }
    const Vector& value() const { return value_; }
    void restart() { *this = LowPass(); }

  private:
    Vector value_ = Vector::Zero();
    Vector rate_ = Vector::Zero();
    float filled_ = 0.0F;
};

}  // namespace stator::apps::attitude
