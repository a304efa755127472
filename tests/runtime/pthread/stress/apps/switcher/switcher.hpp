// Exchanges two modes at each activation.
#pragma once

#include "switcher_ports.hpp"

namespace stator::apps::switcher {

class Switcher {
  public:
    void step(SwitcherPorts& ports) {
        mode_ = static_cast<uint8_t>(1 - mode_);
        ports.mode.publish([&] { return Mode{.timestamp = 0, .mode = mode_, ._padding0 = {}}; });
    }

  private:
    uint8_t mode_ = 0;
};

}  // namespace stator::apps::switcher
