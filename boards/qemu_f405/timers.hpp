// The two timers of this board. They rest on how QEMU 10 emulates timers, which differs from the
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

// TIM2 interrupts at each whole millisecond since reset.
class StepTimer {
  public:
    void start() const {
        kReload.write(1'000'000);
        kInterrupts.write(kUpdate);
        kControl.write(kCounterEnable);
    }
    void acknowledge() const { kStatus.write(0); }

  private:
    static constexpr uint32_t kBase = 0x40000000;
    static constexpr uint32_t kCounterEnable = 1U << 0;
    static constexpr uint32_t kUpdate = 1U << 0;
    static constexpr Register kControl{kBase + 0x00};
    static constexpr Register kInterrupts{kBase + 0x0C};
    static constexpr Register kStatus{kBase + 0x10};
    static constexpr Register kReload{kBase + 0x2C};
};

}  // namespace stator::board
