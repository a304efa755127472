// Goes through three modes.
#pragma once

#include "switcher_ports.hpp"

namespace stator::apps::switcher {

class Switcher {
  public:
    void step(SwitcherPorts& ports) {
        mode_ = mode_ == 2 ? 0 : mode_ + 1;
        ports.mode.publish([&] { return Mode{.mode = static_cast<uint8_t>(mode_)}; });
    }

  private:
    int mode_ = 0;
};

}  // namespace stator::apps::switcher
