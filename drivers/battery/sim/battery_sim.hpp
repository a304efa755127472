// The battery monitor of a simulated board: publishes what the board's battery says when asked.
#pragma once

#include "battery_ports.hpp"

namespace stator::drivers::battery::sim {

class BatterySim {
  public:
    // What the battery says now, which the board writes.
    struct Device {
        float voltage_v = 0.0F;
        float current_a = 0.0F;
        float discharged_mah = 0.0F;
        float remaining = 0.0F;  // 1 to 0
        // Brings this up to date, where the board writes in another thread; else none.
        void (*refresh)(Device&) = nullptr;
    };

    explicit BatterySim(Device& device) : device_(device) {}
    void step(BatteryPorts& ports);

  private:
    Device& device_;
};

}  // namespace stator::drivers::battery::sim
