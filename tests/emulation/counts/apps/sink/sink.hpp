// The end of the way that is counted.
#pragma once

#include "sink_ports.hpp"

namespace stator {

class Sink {
  public:
    void step(SinkPorts& ports);
};

}  // namespace stator
