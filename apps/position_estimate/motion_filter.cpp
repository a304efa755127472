// Position and velocity of a point.
#include "motion_filter.hpp"

namespace stator::apps::position_estimate {

namespace {

// Beyond, a step's gains would take away more than there is: measurements are rare, and the filter
// follows them more slowly.
constexpr float kMaxBandwidthTimesInterval = 0.5F;

}  // namespace

void MotionFilter::restart(const Vector& position, const Vector& velocity) {
    position_ = position;
    velocity_ = velocity;
}

void MotionFilter::predict(const Vector& acceleration, float dt) {
    acceleration_ = acceleration - error_;
    position_ += (velocity_ + acceleration_ * (0.5F * dt)) * dt;
    velocity_ += acceleration_ * dt;
}

MotionFilter::Vector MotionFilter::position_ago(float age) const {
    return position_ - (velocity_ - acceleration_ * (0.5F * age)) * age;
}

void MotionFilter::correct(const Vector& innovation, float dt, float bandwidth,
                           float error_bandwidth) {
    constexpr float kRootTwo = 0x1.6a09e6p+0F;
    const float w = math::min(bandwidth, kMaxBandwidthTimesInterval / dt);
    const float w_e = math::min(error_bandwidth, 0.25F * w);
    position_ += innovation * ((kRootTwo * w + w_e) * dt);
    velocity_ += innovation * ((w * w + kRootTwo * w * w_e) * dt);
    error_ -= innovation * (w * w * w_e * dt);
}

}  // namespace stator::apps::position_estimate
