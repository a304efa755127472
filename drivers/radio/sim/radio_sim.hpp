// The radio receiver of a simulated board: publishes the frame that the board received.
#pragma once

#include <cstdint>

#include "radio_ports.hpp"

namespace stator::drivers::radio::sim {

class RadioSim {
  public:
    // The newest frame. The board writes it, then raises received. A receiver that hears nothing
    // goes on with the last frame and says so.
    struct Device {
        uint64_t timestamp_sample = 0;  // us
        float roll = 0.0F;              // sticks: -1 to 1
        float pitch = 0.0F;
        float yaw = 0.0F;
        float throttle = 0.0F;
        uint32_t mode_slot = 0;
        bool is_heard = false;
        bool arm = false;
        bool return_home = false;
        bool kill = false;
    };

    explicit RadioSim(Device& device) : device_(device) {}
    void step(RadioPorts& ports);

  private:
    Device& device_;
};

}  // namespace stator::drivers::radio::sim
