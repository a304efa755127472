// A hysteresis in time, which keeps short interruptions out: a condition counts once it has held
// for long enough. It stops counting at once.
#pragma once

#include "stator/scalar.hpp"

namespace stator::apps::commander {

class Hysteresis {
  public:
    // Says whether it has now held for `min_s` without a break.
    bool update(bool holds, float dt, float min_s) {
        for_s_ = holds ? math::min(for_s_ + dt, kMax_s) : 0.0F;
        return holds && for_s_ >= min_s;
    }
    void reset() { for_s_ = 0.0F; }

  private:
    static constexpr float kMax_s = 1e5F;
    float for_s_ = 0.0F;
};

}  // namespace stator::apps::commander
