// Has parameters, and does nothing with them.
#pragma once

#include "dial_ports.hpp"

namespace stator::apps::dial {

class Dial {
  public:
    void step(DialPorts&) {}
};

}  // namespace stator::apps::dial
