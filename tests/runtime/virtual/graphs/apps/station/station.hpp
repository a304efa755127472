// A node that tells the tests everything it sees.
#pragma once

#include <cstdint>

#include "station_ports.hpp"

namespace stator::apps::station {

class Station {
  public:
    void step(StationPorts& ports);

  private:
    uint32_t activations_ = 0;
    uint32_t published_ = 0;
};

}  // namespace stator::apps::station
