// A timer whose channels give pulses (RM0090, 17.3.9 and 18.3.8): the count is a microsecond, and a
// new width counts from the next period on, so no pulse is cut.
#pragma once

#include <cstdint>

#include "stator/registers.hpp"

namespace stator::stm32f4 {

class PwmTimer {
  public:
    // `clock_hz`: of the timer, whose bus clock is on. `has_break`: TIM1, whose outputs have one
    // more switch.
    constexpr PwmTimer(uint32_t base, uint32_t clock_hz, bool has_break)
        : base_(base), clock_hz_(clock_hz), has_break_(has_break) {}

    // `channels`: bit i for channel i + 1. They stay low until their first width.
    void start(uint32_t period_us, uint32_t channels) const {
        at(kPrescaler).write(clock_hz_ / 1'000'000U - 1);
        at(kReload).write(period_us - 1);
        at(kMode).write(kMode1Both);
        at(kMode + 4).write(kMode1Both);
        at(kEvent).write(kUpdate);
        at(kOutputs).write((channels & 1) | (channels & 2) << 3 | (channels & 4) << 6 |
                           (channels & 8) << 9);
        if (has_break_) at(kBreak).write(kMainOutput);
        at(kControl).write(kEnable | kPreload);
    }
    // `channel`: 1 to 4.
    void write(uint32_t channel, uint32_t width_us) const {
        at(kCompare + 4 * (channel - 1)).write(width_us);
    }

  private:
    static constexpr uint32_t kControl = 0x00;  // TIMx_CR1
    static constexpr uint32_t kEnable = 1U << 0;
    static constexpr uint32_t kPreload = 1U << 7;
    static constexpr uint32_t kEvent = 0x14;  // TIMx_EGR
    static constexpr uint32_t kUpdate = 1U << 0;
    static constexpr uint32_t kMode = 0x18;             // TIMx_CCMR1
    static constexpr uint32_t kMode1Both = 0x68 * 257;  // PWM mode 1 with preload, twice
    static constexpr uint32_t kOutputs = 0x20;          // TIMx_CCER
    static constexpr uint32_t kPrescaler = 0x28;        // TIMx_PSC
    static constexpr uint32_t kReload = 0x2C;           // TIMx_ARR
    static constexpr uint32_t kCompare = 0x34;          // TIMx_CCR1
    static constexpr uint32_t kBreak = 0x44;            // TIM1_BDTR
    static constexpr uint32_t kMainOutput = 1U << 15;

    Register at(uint32_t offset) const { return Register(base_ + offset); }

    uint32_t base_;
    uint32_t clock_hz_;
    bool has_break_;
};

}  // namespace stator::stm32f4
