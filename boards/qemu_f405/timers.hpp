// The timers of this board. They rest on how QEMU 10 emulates timers, which differs from the
// chip: a counter runs at 1 GHz / (PSC + 1) whatever the clock tree says, and does not wrap at ARR;
// the update interrupt comes each ARR nanoseconds as long as PSC, EGR and CNT were never written.
// Registers: RM0090, section 18.4 (TIM2 to TIM5).
#pragma once

#include "stator/registers.hpp"

namespace stator::board {

// The clock: TIM5 counts microseconds since reset.
class Clock {
  public:
    void start() const {
        kControl.write(kCounterEnable);
        const uint32_t since_reset_us = kCounter.read() / 1000U;
        kPrescaler.write(999);
        kCounter.write(since_reset_us);
    }
    uint32_t us() const { return kCounter.read(); }

  private:
    static constexpr uint32_t kBase = 0x40000C00;
    static constexpr uint32_t kCounterEnable = 1U << 0;
    static constexpr Register kControl{kBase + 0x00};
    static constexpr Register kCounter{kBase + 0x24};
    static constexpr Register kPrescaler{kBase + 0x28};
};

// Interrupts at each whole multiple of a period since reset.
class PeriodicTimer {
  public:
    constexpr PeriodicTimer(uint32_t base, uint8_t vector, uint32_t period_us)
        : base_(base), vector_(vector), period_us_(period_us) {}
    // At hardware priority 0.
    void start() const {
        Register(base_ + kReload).write(period_us_ * 1000U);
        Register(base_ + kInterrupts).write(kUpdate);
        Register(base_ + kControl).write(kCounterEnable);
        nvic::priority(vector_) = 0;
        nvic::set_enable(vector_ / 32U).write(1U << vector_ % 32U);
    }
    void acknowledge() const { Register(base_ + kStatus).write(0); }
    // Nanoseconds. In this emulator they do not restart with a period.
    uint32_t ns() const { return Register(base_ + kCount).read(); }

  private:
    static constexpr uint32_t kCounterEnable = 1U << 0;
    static constexpr uint32_t kUpdate = 1U << 0;
    static constexpr uint32_t kControl = 0x00;
    static constexpr uint32_t kInterrupts = 0x0C;
    static constexpr uint32_t kStatus = 0x10;
    static constexpr uint32_t kCount = 0x24;
    static constexpr uint32_t kReload = 0x2C;
    uint32_t base_;
    uint8_t vector_;
    uint32_t period_us_;
};

inline constexpr PeriodicTimer kStepTimer(0x40000000, 28, 1'000);        // TIM2
inline constexpr PeriodicTimer kWatchdogTimer(0x40000400, 29, 100'000);  // TIM3

}  // namespace stator::board
