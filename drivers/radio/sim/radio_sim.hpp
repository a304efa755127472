// The radio receiver of a simulated board: publishes the frame that the board received.
#pragma once

#include "radio_ports.hpp"
#include "radio_sim_sample.hpp"

namespace stator::drivers::radio::sim {

class RadioSim {
  public:
    // The newest frame. The board writes it, then raises received. A receiver that hears nothing
    // goes on with the last frame and says so.
    using Device = RadioSimSample;

    explicit RadioSim(Device& device) : device_(device) {}
    void step(RadioPorts& ports);

  private:
    Device& device_;
};

}  // namespace stator::drivers::radio::sim
