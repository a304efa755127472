// A faulty node: what a run does about an activation that does not end.
#pragma once

#include <cstdint>

#include "endless_ports.hpp"

namespace stator::apps::endless {

class Endless {
  public:
    void step(EndlessPorts& ports);

  private:
    volatile uint32_t counted_ = 0;  // volatile: a loop without effects may be left out
};

}  // namespace stator::apps::endless
