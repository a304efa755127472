// The motors of a simulated board: each command goes to the board at the instant it comes.
#pragma once

#include <array>

#include "motor_ports.hpp"

namespace stator::drivers::motor::sim {

class MotorSim {
  public:
    // Not a number: stopped. Else the fraction of a motor's most thrust.
    using Control = std::array<float, 12>;
    // The board puts its function here; without one, commands go nowhere.
    struct Device {
        void (*write)(const Control& control) = nullptr;
    };

    explicit MotorSim(Device& device) : device_(device) {}
    void step(MotorPorts& ports);

  private:
    Device& device_;
};

}  // namespace stator::drivers::motor::sim
