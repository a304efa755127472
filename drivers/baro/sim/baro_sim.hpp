// The barometer of a simulated board: publishes each sample that the board measured once.
#pragma once

#include <cstdint>

#include "baro_ports.hpp"
#include "baro_sim_sample.hpp"
#include "stator/newest.hpp"

namespace stator::drivers::baro::sim {

class BaroSim {
  public:
    // The newest sample, which the board writes.
    using Device = Newest<BaroSimSample>;

    explicit BaroSim(Device& device) : device_(device) {}
    void step(BaroPorts& ports);

  private:
    Device& device_;
    uint32_t published_ = 0;
};

}  // namespace stator::drivers::baro::sim
