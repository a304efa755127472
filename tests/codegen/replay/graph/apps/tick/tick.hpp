// Counts since it was constructed.
#pragma once

#include <cstdint>

#include "tick_ports.hpp"

namespace stator::apps::tick {

class Tick {
  public:
    void step(TickPorts& ports) {
        ++counted_;
        const auto value = static_cast<float>(counted_ * ports.params->stride);
        const uint32_t seen = ports.params.is_new() ? 1 : 0;
        ports.count.publish([&] { return Reading{.value = value, .seen = seen}; });
    }

  private:
    int32_t counted_ = 0;
};

}  // namespace stator::apps::tick
