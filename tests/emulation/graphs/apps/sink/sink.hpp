// The end of the way that is counted.
#pragma once

#include "../../counting.hpp"
#include "sink_ports.hpp"

namespace stator::apps::sink {

class Sink {
  public:
    void step(SinkPorts& ports) { counting::reach(counting::Place::kStep, &*ports.sample); }
};

}  // namespace stator::apps::sink
