// Takes turns between two modes.
#pragma once

#include "switcher_ports.hpp"

namespace stator::apps::switcher {

class Switcher {
  public:
    void step(SwitcherPorts& ports) {
        mode_ = static_cast<uint8_t>(1 - mode_);
        ports.mode.publish([&] { return Mode{.mode = mode_}; });
    }

  private:
    uint8_t mode_ = 0;
};

}  // namespace stator::apps::switcher
