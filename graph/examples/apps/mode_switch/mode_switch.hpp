// Goes through the modes of a graph with two, one activation each.
#pragma once

#include <cstdint>

#include "mode_switch_ports.hpp"

namespace stator::apps::mode_switch {

class ModeSwitch {
  public:
    void step(ModeSwitchPorts& ports);

  private:
    uint8_t mode_ = 0;
};

}  // namespace stator::apps::mode_switch
