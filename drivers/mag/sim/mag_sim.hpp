// The magnetometer of a simulated board: publishes what the board measured.
#pragma once

#include "mag_ports.hpp"
#include "mag_sim_sample.hpp"

namespace stator::drivers::mag::sim {

class MagSim {
  public:
    // The newest sample. The board writes it, then raises data_ready.
    using Device = MagSimSample;

    explicit MagSim(Device& device) : device_(device) {}
    void step(MagPorts& ports);

  private:
    Device& device_;
};

}  // namespace stator::drivers::mag::sim
