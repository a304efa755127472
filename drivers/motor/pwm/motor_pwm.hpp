// Motors behind speed controllers that read the width of pulses. Without a command for a while, an
// activation by a timer stops them.
#pragma once

#include <array>
#include <cstdint>

#include "motor_ports.hpp"

namespace stator::drivers::motor::pwm {

class MotorPwm {
  public:
    static constexpr unsigned kMotors = 6;
    using Pulses = std::array<uint16_t, kMotors>;  // us
    // The board puts its function here; it gives no pulse before the first call.
    struct Device {
        void (*write)(const Pulses& pulses_us) = nullptr;
    };
    // PX4's defaults (PWM_MIN, PWM_MAX, and its value for disarmed ones), which speed controllers
    // are sold with: below the first one a motor stands.
    static constexpr float kMinPulse_us = 1075.0F;
    static constexpr float kMaxPulse_us = 1950.0F;
    static constexpr uint16_t kStopped_us = 900;

    explicit MotorPwm(Device& device) : device_(device) {}
    void step(MotorPorts& ports);

  private:
    static constexpr uint64_t kSilent_us = 1'300'000;

    Device& device_;
    uint64_t commanded_us_ = 0;
};

}  // namespace stator::drivers::motor::pwm
