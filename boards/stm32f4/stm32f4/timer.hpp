// TIM5, a 32-bit counter, as the clock that never stops: microseconds (RM0090, 18.4).
#pragma once

#include <cstdint>

#include "stator/registers.hpp"
#include "stm32f4/clock_tree.hpp"

namespace stator::stm32f4 {

class MicrosecondTimer {
  public:
    void start() const {
        rcc::kApb1Enable.set(kTimer5Clock);
        kPrescaler.write(kApb1TimerClock_hz / 1'000'000U - 1);
        kReload.write(0xFFFFFFFF);
        kEvent.write(kUpdate);  // the prescaler counts from the next update on: 18.4.11
        kControl.write(kEnable);
    }
    uint32_t us() const { return kCounter.read(); }

  private:
    static constexpr uint32_t kBase = 0x40000C00;
    static constexpr uint32_t kTimer5Clock = 1U << 3;
    static constexpr uint32_t kEnable = 1U << 0;
    static constexpr uint32_t kUpdate = 1U << 0;
    static constexpr Register kControl{kBase + 0x00};
    static constexpr Register kEvent{kBase + 0x14};
    static constexpr Register kCounter{kBase + 0x24};
    static constexpr Register kPrescaler{kBase + 0x28};
    static constexpr Register kReload{kBase + 0x2C};
};

// TIM3, which raises its vector once a millisecond.
class MillisecondTick {
  public:
    void start() const {
        rcc::kApb1Enable.set(kTimer3Clock);
        Register(kBase + 0x28).write(kApb1TimerClock_hz / 1'000'000U - 1);  // TIMx_PSC
        Register(kBase + 0x2C).write(999);                                  // TIMx_ARR
        Register(kBase + 0x14).write(kUpdate);                              // TIMx_EGR
        acknowledge();
        Register(kBase + 0x0C).write(kUpdate);  // TIMx_DIER
        Register(kBase + 0x00).write(kUpdate);  // TIMx_CR1
    }
    void acknowledge() const { Register(kBase + 0x10).write(0); }  // TIMx_SR

  private:
    static constexpr uint32_t kBase = 0x40000400;
    static constexpr uint32_t kTimer3Clock = 1U << 1;
    static constexpr uint32_t kUpdate = 1U << 0;
};

}  // namespace stator::stm32f4
