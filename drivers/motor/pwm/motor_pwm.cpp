// The width of a pulse is linear in the thrust, as PX4 has it without a thrust model.
#include "motor_pwm.hpp"

#include <algorithm>

namespace stator::drivers::motor::pwm {

namespace {

// A motor that is not to turn has not a number.
uint16_t pulse_us(float control) {
    if (!(control >= 0.0F)) return MotorPwm::kStopped_us;
    const float thrust = std::min(control, 1.0F);
    const float width =
        MotorPwm::kMinPulse_us + thrust * (MotorPwm::kMaxPulse_us - MotorPwm::kMinPulse_us);
    return static_cast<uint16_t>(width + 0.5F);  // in range: no saturation
}

}  // namespace

void MotorPwm::step(MotorPorts& ports) {
    if (ports.command) commanded_us_ = ports.now;
    const bool is_silent = commanded_us_ != 0 && ports.now > commanded_us_ + kSilent_us;
    if (device_.write == nullptr || (!ports.command && !is_silent)) return;
    Pulses pulses_us;
    pulses_us.fill(kStopped_us);
    if (ports.command)
        for (unsigned i = 0; i < kMotors; ++i) pulses_us[i] = pulse_us(ports.command->control[i]);
    device_.write(pulses_us);
}

}  // namespace stator::drivers::motor::pwm
