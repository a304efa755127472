// Exchanges two modes at each event.
#pragma once

#include "../../journal.hpp"
#include "switcher_ports.hpp"

namespace stator::apps::switcher {

class Switcher {
  public:
    // Without an event nothing changes; nothing else activates it.
    void step(SwitcherPorts& ports) {
        if (!ports.in) return;
        mode_ = static_cast<uint8_t>(1 - mode_);
        semihosting::print("M");
        ports.mode.publish([&] { return Mode{.mode = mode_}; });
    }

  private:
    uint8_t mode_ = 0;
};

}  // namespace stator::apps::switcher
