// Adds up counts, and the newest of something else.
#pragma once

#include <limits>

#include "gather_ports.hpp"

namespace stator::apps::gather {

class Gather {
  public:
    void step(GatherPorts& ports) {
        if (ports.count) sum_ += ports.count->value;
        const uint32_t seen = (ports.count.is_new() ? 1U : 0U) + (ports.extra.is_new() ? 2U : 0U);
        ports.sum.publish([&] {
            return Reading{.value = ports.extra ? sum_ + ports.extra->value : sum_,
                           .seen = seen + 4 * ports.fired.timers,
                           .lost = ports.count.lost() + 1000 * ports.extra.lost()};
        });
        if (ports.fired.timers == 0) return;
        // Not a number with a sign and a payload, which a recording makes canonical.
        ports.sum.publish(
            [] { return Reading{.value = -std::numeric_limits<float>::signaling_NaN()}; });
        ports.sum.publish([] { return Reading{.value = 1.0F}; });  // refused: one too many
    }

  private:
    float sum_ = 0.0F;
};

}  // namespace stator::apps::gather
