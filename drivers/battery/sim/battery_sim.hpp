// The battery monitor of a simulated board: publishes what the board's battery says when asked.
#pragma once

#include "battery_ports.hpp"
#include "battery_sim_sample.hpp"
#include "stator/newest.hpp"

namespace stator::drivers::battery::sim {

class BatterySim {
  public:
    // What the battery says now, which the board writes.
    using Device = Newest<BatterySimSample>;

    explicit BatterySim(Device& device) : device_(device) {}
    void step(BatteryPorts& ports);

  private:
    Device& device_;
};

}  // namespace stator::drivers::battery::sim
