// The mission of a simulated board: publishes what the board was given.
#pragma once

#include <cstdint>

#include "mission_ports.hpp"

namespace stator::drivers::mission::sim {

class MissionSim {
  public:
    // The board writes a mission and counts it.
    struct Device {
        Mission mission{};
        uint32_t version = 0;  // 0: there is none
    };

    explicit MissionSim(Device& device) : device_(device) {}
    void step(MissionPorts& ports);

  private:
    Device& device_;
    uint32_t published_ = 0;  // the version
};

}  // namespace stator::drivers::mission::sim
