// Lets counting begin one higher each time: asks for a parameter of another node.
#pragma once

#include "adjuster_ports.hpp"

namespace stator::apps::adjuster {

class Adjuster {
  public:
    void step(AdjusterPorts& ports);
};

}  // namespace stator::apps::adjuster
