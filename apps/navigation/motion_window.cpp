// The motions between the filter's horizon and now.
#include "motion_window.hpp"

namespace stator::apps::navigation {

void MotionWindow::restart(uint64_t now_us, const ImuBias& bias) {
    horizon_ = newest_ = anchor_ = 0;
    ends_[0] = {Motion(), now_us};
    now_ = Motion();
    bias_ = earlier_bias_ = bias;
}

void MotionWindow::close(uint64_t now_us, const ImuBias& newest) {
    ++newest_;
    now_.turn = math::normalized(now_.turn);
    ends_[newest_ % kCapacity] = {now_, now_us};
    // Nothing before the anchor is needed any more.
    if (horizon_ <= anchor_) return;
    anchor_ = newest_;
    now_ = Motion();
    earlier_bias_ = bias_;
    bias_ = newest;
}

MotionWindow::Step MotionWindow::take() {
    const bool after_anchor = horizon_ >= anchor_;
    const Motion start = start_of(horizon_);
    ++horizon_;
    return {.motion = between(start, at(horizon_).since_anchor),
            .bias = after_anchor ? bias_ : earlier_bias_,
            .end_us = at(horizon_).end_us};
}

Motion MotionWindow::ahead() const {
    if (horizon_ >= anchor_) return between(start_of(horizon_), now_);
    return between(at(horizon_).since_anchor, at(anchor_).since_anchor) * now_;
}

}  // namespace stator::apps::navigation
