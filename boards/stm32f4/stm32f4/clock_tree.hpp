// Brings the chip to 168 MHz, and switches the clocks of peripherals on.
// Sections are of RM0090 revision 19; chapter 6 is for STM32F42x, chapter 7 the same for STM32F40x.
#pragma once

#include <cstdint>

#include "stator/registers.hpp"

namespace stator::stm32f4 {

// Reset and clock control (6.3).
namespace rcc {
inline constexpr Register kControl(0x40023800);        // RCC_CR, 6.3.1
inline constexpr Register kPll(0x40023804);            // RCC_PLLCFGR, 6.3.2
inline constexpr Register kConfiguration(0x40023808);  // RCC_CFGR, 6.3.3
inline constexpr Register kAhb1Enable(0x40023830);     // RCC_AHB1ENR, 6.3.10
inline constexpr Register kApb1Enable(0x40023840);     // RCC_APB1ENR, 6.3.13
inline constexpr Register kApb2Enable(0x40023844);     // RCC_APB2ENR, 6.3.14
inline constexpr Register kStatus(0x40023874);         // RCC_CSR, 6.3.21
}  // namespace rcc

// Bus clocks at 168 MHz: timers of a divided bus run at twice its clock (6.2).
inline constexpr uint32_t kCoreClock_hz = 168'000'000;
inline constexpr uint32_t kApb1Clock_hz = 42'000'000;
inline constexpr uint32_t kApb2Clock_hz = 84'000'000;
inline constexpr uint32_t kApb1TimerClock_hz = 84'000'000;
inline constexpr uint32_t kApb2TimerClock_hz = 168'000'000;

enum class ClockSource {
    kCrystal,   // as planned
    kInternal,  // the crystal did not start: 168 MHz from the internal oscillator, 1 % off
    kNone,      // no PLL: still at 16 MHz, and every time would be wrong; the caller must not go on
};

// Starts the crystal of `crystal_mhz` (4 to 26), the PLL and the flash's wait states. Takes at most
// a few ms. Before anything else runs; once.
[[nodiscard]] ClockSource start_clocks(uint32_t crystal_mhz);

// Why the chip was last reset (6.3.21), read once and cleared, so that the next reset is
// seen as another one.
struct ResetCause {
    bool by_watchdog;  // independent or window
    bool by_software;
    bool by_pin;
    bool by_power;  // power-on or brown-out
};
ResetCause take_reset_cause();

}  // namespace stator::stm32f4
