// Exchanges two modes at each wish.
#pragma once

#include "../../trace.hpp"
#include "switcher_ports.hpp"

namespace stator::apps::switcher {

class Switcher {
  public:
    // Without a wish nothing changes; nothing else activates it.
    void step(SwitcherPorts& ports) {
        if (!ports.wish) return;
        mode_ = static_cast<uint8_t>(1 - mode_);
        trace::Line(ports.now, " +#", ports.params->id).text(" to ").number(mode_).write();
        ports.mode.publish([&] { return Mode{.mode = mode_}; });
        trace::Line(ports.now, " -#", ports.params->id).write();
    }

  private:
    uint8_t mode_ = 0;
};

}  // namespace stator::apps::switcher
