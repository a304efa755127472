// A condition that counts once it has lasted.
#pragma once

#include "stator/scalar.hpp"

namespace stator::apps::commander {

class Lasting {
  public:
    // Says whether it has now held for `least_s` without a break.
    bool update(bool holds, float dt, float least_s) {
        for_s_ = holds ? math::min(for_s_ + dt, kMost_s) : 0.0F;
        return holds && for_s_ >= least_s;
    }
    void reset() { for_s_ = 0.0F; }

  private:
    static constexpr float kMost_s = 1e5F;
    float for_s_ = 0.0F;
};

}  // namespace stator::apps::commander
