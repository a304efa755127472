// The mean of a sensor at rest.
#pragma once

#include "stator/rotation.hpp"

namespace stator::apps::calibration {

using Vector = math::Vector3<float>;

// Averages samples that stay close to the first of them; one that does not begins a new average.
class Still {
  public:
    explicit Still(float tolerance) : tolerance_(tolerance) {}

    void clear() { count_ = 0; }
    // False: it was moved.
    bool add(const Vector& sample) {
        const bool is_close = count_ == 0 || math::norm(sample - first_) <= tolerance_;
        if (!is_close) clear();
        if (count_ == 0) {
            first_ = sample;
            sum_ = Vector::Zero();
        }
        // Of what differs, so that the sum of many keeps its last bits.
        sum_ += sample - first_;
        ++count_;
        return is_close;
    }
    unsigned count() const { return count_; }
    Vector mean() const { return first_ + sum_ / static_cast<float>(count_); }

  private:
    float tolerance_;
    Vector first_ = Vector::Zero();
    Vector sum_ = Vector::Zero();
    unsigned count_ = 0;
};

}  // namespace stator::apps::calibration
