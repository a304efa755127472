// Lets counting begin one higher each time: asks for a parameter of another node.
#pragma once

#include "adjuster_ports.hpp"

namespace stator {

class Adjuster {
  public:
    void step(AdjusterPorts& ports);
};

}  // namespace stator
