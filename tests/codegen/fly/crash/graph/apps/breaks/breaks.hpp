#pragma once

#include <array>

#include "breaks_ports.hpp"

namespace stator::apps::breaks {

class Breaks {
  public:
    void step(BreaksPorts& ports);

  private:
    int descend(int n);

    volatile int zero_ = 0;
    std::array<uint32_t, 4> values_{};
    uint32_t count_ = 0;
};

}  // namespace stator::apps::breaks
