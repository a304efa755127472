// Adds up what others have counted.
#pragma once

#include <cstdint>

#include "adder_ports.hpp"

namespace stator {

class Adder {
  public:
    void step(AdderPorts& ports);

  private:
    uint32_t sum_ = 0;
};

}  // namespace stator
