// The motion capture of a simulated board: publishes what the board received.
#pragma once

#include "mocap_ports.hpp"
#include "mocap_sim_sample.hpp"

namespace stator::drivers::mocap::sim {

class MocapSim {
  public:
    // The newest measurement received. The board writes it, then raises received.
    using Device = MocapSimSample;

    explicit MocapSim(Device& device) : device_(device) {}
    void step(MocapPorts& ports);

  private:
    Device& device_;
};

}  // namespace stator::drivers::mocap::sim
