// The pitot tube of a simulated board: publishes each sample that the board measured once.
#pragma once

#include <cstdint>

#include "airspeed_ports.hpp"
#include "airspeed_sim_sample.hpp"
#include "stator/newest.hpp"

namespace stator::drivers::airspeed::sim {

class AirspeedSim {
  public:
    // The newest sample, which the board writes.
    using Device = Newest<AirspeedSimSample>;

    explicit AirspeedSim(Device& device) : device_(device) {}
    void step(AirspeedPorts& ports);

  private:
    Device& device_;
    uint32_t published_ = 0;
};

}  // namespace stator::drivers::airspeed::sim
