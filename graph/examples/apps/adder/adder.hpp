// Adds up what others have counted.
#pragma once

#include <cstdint>

#include "adder_ports.hpp"

namespace stator::apps::adder {

class Adder {
  public:
    void step(AdderPorts& ports);

  private:
    uint32_t sum_ = 0;
};

}  // namespace stator::apps::adder
