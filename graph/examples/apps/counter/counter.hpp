// Counts its own activations: the smallest node that does something.
#pragma once

#include <cstdint>

#include "counter_ports.hpp"

namespace stator::apps::counter {

class Counter {
  public:
    void step(CounterPorts& ports);

  private:
    uint32_t counted_ = 0;
};

}  // namespace stator::apps::counter
