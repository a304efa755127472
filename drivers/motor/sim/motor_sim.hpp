// The motors of a simulated board: each command goes to the board at the instant it comes. Without
// one for a while, an activation by a timer stops them.
#pragma once

#include <array>
#include <cstdint>

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
    static constexpr uint64_t kSilent_us = 1'300'000;

    Device& device_;
    uint64_t commanded_us_ = 0;
};

}  // namespace stator::drivers::motor::sim
