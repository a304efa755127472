// The motions between the filter's horizon and now, in steps.
//
// Each step's end is kept as the motion since an anchor, so that both the step at the horizon and
// the whole way from there to now are one or two products, however many steps lie between. The
// anchor is moved on once per window, so that rounding does not gather.
#pragma once

#include <array>
#include <cstdint>

#include "motion.hpp"

namespace stator::apps::navigation {

struct ImuBias {
    Vector gyro = Vector::Zero();   // rad/s
    Vector accel = Vector::Zero();  // m/s^2
};

class MotionWindow {
  public:
    // 0.5 s of 8 ms.
    static constexpr uint32_t kCapacity = 64;

    struct Step {
        Motion motion;
        ImuBias bias;  // that was taken off already
        uint64_t end_us;
    };

    void restart(uint64_t now_us, const ImuBias& bias);

    // Takes the bias off and adds what was felt on average over `time`.
    void add(const Vector& rate_B, const Vector& force_B, float time) {
        now_ = now_ * constant_motion(rate_B - bias_.gyro, force_B - bias_.accel, time);
    }
    // Time since the last step's end.
    float open_time() const { return now_.time - start_of(newest_).time; }
    // Ends a step. The window must not be full.
    void close(uint64_t now_us, const ImuBias& newest);

    bool empty() const { return horizon_ == newest_; }
    bool full() const { return newest_ - horizon_ == kCapacity - 1; }
    // When the oldest step ends.
    uint64_t step_end_us() const { return at(horizon_ + 1).end_us; }
    // The oldest step; the horizon moves to its end.
    Step take();
    // From the horizon to now.
    Motion ahead() const;

  private:
    struct End {
        Motion since_anchor;
        uint64_t end_us = 0;
    };

    const End& at(uint32_t index) const { return ends_[index % kCapacity]; }
    Motion start_of(uint32_t index) const {
        return index == anchor_ ? Motion() : at(index).since_anchor;
    }

    std::array<End, kCapacity> ends_{};
    Motion now_;            // since the anchor
    ImuBias bias_;          // taken off after the anchor
    ImuBias earlier_bias_;  // and before it
    // Numbers of ends, which only grow.
    uint32_t horizon_ = 0;
    uint32_t newest_ = 0;
    uint32_t anchor_ = 0;
};

}  // namespace stator::apps::navigation
