// The independent watchdog (RM0090, 21.4): an oscillator of its own, which nothing but a reset
// stops once it runs.
#pragma once

#include <cstdint>

#include "stator/registers.hpp"
#include "wait.hpp"

namespace stator::stm32f4 {

class Watchdog {
  public:
    // Resets the chip when it was not kicked for `timeout_ms` (1 to 4095, at the nominal 32 kHz;
    // the oscillator is between 17 and 47 kHz, so it may be two thirds or twice of that). False:
    // the hardware did not take the values within their bound, and it runs with its longest
    // time-out.
    [[nodiscard]] bool start(uint32_t timeout_ms) const {
        kKey.write(kStart);
        kKey.write(kUnlock);
        kPrescaler.write(kBy32);
        kReload.write(timeout_ms - 1);
        const bool taken = wait_until(kStatus, kUpdating, 0, kMaxReads);
        kick();
        return taken;
    }
    void kick() const { kKey.write(kRestart); }

  private:
    static constexpr Register kKey{0x40003000};        // IWDG_KR
    static constexpr Register kPrescaler{0x40003004};  // IWDG_PR
    static constexpr Register kReload{0x40003008};     // IWDG_RLR
    static constexpr Register kStatus{0x4000300C};     // IWDG_SR
    static constexpr uint32_t kStart = 0xCCCC;
    static constexpr uint32_t kUnlock = 0x5555;
    static constexpr uint32_t kRestart = 0xAAAA;
    static constexpr uint32_t kBy32 = 3;  // 1 ms a count at 32 kHz
    static constexpr uint32_t kUpdating = 3;
    // Five cycles of the slow oscillator (21.4.4) are 300 us at 17 kHz: 50,000 cycles of 168 MHz.
    static constexpr uint32_t kMaxReads = 50'000;
};

}  // namespace stator::stm32f4
