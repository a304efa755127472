// The servos of a simulated board: each command goes to the board at the instant it comes.
#pragma once

#include <array>

#include "servo_ports.hpp"

namespace stator::drivers::servo::sim {

class ServoSim {
  public:
    // Not a number: neutral. Else the fraction of a surface's most deflection.
    using Control = std::array<float, 8>;
    // The board puts its function here; without one, commands go nowhere.
    struct Device {
        void (*write)(const Control& control) = nullptr;
    };

    explicit ServoSim(Device& device) : device_(device) {}
    void step(ServoPorts& ports);

  private:
    Device& device_;
};

}  // namespace stator::drivers::servo::sim
