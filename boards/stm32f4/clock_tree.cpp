// Oscillators, PLL, bus dividers, wait states, in the order that the manual wants.
#include "stm32f4/clock_tree.hpp"

#include "stm32f4/wait.hpp"

namespace stator::stm32f4 {

namespace {

// RCC_CR
constexpr uint32_t kHsiOn = 1U << 0;
constexpr uint32_t kHsiReady = 1U << 1;
constexpr uint32_t kHseOn = 1U << 16;
constexpr uint32_t kHseReady = 1U << 17;
constexpr uint32_t kPllOn = 1U << 24;
constexpr uint32_t kPllReady = 1U << 25;
// RCC_PLLCFGR. The PLL's input is 1 MHz, its oscillator 336 MHz, its output that by 2; USB gets 48.
constexpr uint32_t kOscillator_mhz = 336;
constexpr uint32_t kPllN = kOscillator_mhz << 6;
constexpr uint32_t kPllPBy2 = 0U << 16;
constexpr uint32_t kPllFromHse = 1U << 22;
constexpr uint32_t kPllQ = 7U << 24;
constexpr uint32_t kPllReserved = 0xF0BC8000;  // keeps its reset value
constexpr uint32_t kHsi_mhz = 16;
// RCC_CFGR
constexpr uint32_t kSwitchMask = 3U << 0;
constexpr uint32_t kSwitchToHsi = 0U << 0;
constexpr uint32_t kSwitchToPll = 2U << 0;
constexpr uint32_t kSwitchStatusMask = 3U << 2;
constexpr uint32_t kSwitchedToHsi = 0U << 2;
constexpr uint32_t kSwitchedToPll = 2U << 2;
constexpr uint32_t kApb1By4 = 5U << 10;
constexpr uint32_t kApb2By2 = 4U << 13;
// RCC_APB1ENR
constexpr uint32_t kPowerClock = 1U << 28;
// PWR_CR, 5.4.1: voltage scale 1 is needed from 144 MHz on (F42x) and is one bit on F40x.
constexpr Register kPowerControl(0x40007000);
constexpr uint32_t kVoltageScale1 = 3U << 14;
// FLASH_ACR, 3.9.1: 5 wait states at 2.7 to 3.6 V and 150 to 168 MHz (table 11), caches, prefetch.
constexpr Register kFlashAccess(0x40023C00);
constexpr uint32_t kWaitStates = 5;
constexpr uint32_t kPrefetch = 1U << 8;
constexpr uint32_t kCaches = 3U << 9;
// RCC_CSR
constexpr uint32_t kRemoveFlags = 1U << 24;
constexpr uint32_t kBrownOut = 1U << 25;
constexpr uint32_t kPin = 1U << 26;
constexpr uint32_t kPowerOn = 1U << 27;
constexpr uint32_t kSoftware = 1U << 28;
constexpr uint32_t kWatchdogs = 3U << 29;

// The crystal takes about 2 ms to start (data sheet, table of HSE characteristics); a read takes at
// least 2 cycles of 16 MHz, so this waits 12 ms or more. The PLL locks within 300 us.
constexpr uint32_t kMaxCrystalReads = 100'000;
constexpr uint32_t kMaxPllReads = 10'000;

bool switch_clock(uint32_t to, uint32_t switched) {
    rcc::kConfiguration.write((rcc::kConfiguration.read() & ~kSwitchMask) | to);
    return wait_until(rcc::kConfiguration, kSwitchStatusMask, switched, kMaxPllReads);
}

// A bootloader may have left the PLL running, and a running one cannot be changed (6.3.2).
bool stop_pll() {
    rcc::kControl.set(kHsiOn);
    if (!wait_until(rcc::kControl, kHsiReady, kHsiReady, kMaxPllReads)) return false;
    if (!switch_clock(kSwitchToHsi, kSwitchedToHsi)) return false;
    rcc::kControl.clear(kPllOn);
    return wait_until(rcc::kControl, kPllReady, 0, kMaxPllReads);
}

bool start_pll(uint32_t input_mhz, uint32_t source) {
    if (!stop_pll()) return false;
    const uint32_t reserved = rcc::kPll.read() & kPllReserved;
    rcc::kPll.write(reserved | input_mhz | kPllN | kPllPBy2 | source | kPllQ);
    rcc::kControl.set(kPllOn);
    if (!wait_until(rcc::kControl, kPllReady, kPllReady, kMaxPllReads)) return false;
    // Before the clock rises: 3.5.1.
    kFlashAccess.write(kWaitStates | kPrefetch | kCaches);
    rcc::kConfiguration.set(kApb1By4 | kApb2By2);
    return switch_clock(kSwitchToPll, kSwitchedToPll);
}

}  // namespace

ClockSource start_clocks(uint32_t crystal_mhz) {
    rcc::kApb1Enable.set(kPowerClock);
    kPowerControl.set(kVoltageScale1);
    rcc::kControl.set(kHseOn);
    if (wait_until(rcc::kControl, kHseReady, kHseReady, kMaxCrystalReads)) {
        return start_pll(crystal_mhz, kPllFromHse) ? ClockSource::kCrystal : ClockSource::kNone;
    }
    rcc::kControl.clear(kHseOn);
    return start_pll(kHsi_mhz, 0) ? ClockSource::kInternal : ClockSource::kNone;
}

ResetCause take_reset_cause() {
    const uint32_t flags = rcc::kStatus.read();
    rcc::kStatus.set(kRemoveFlags);
    return {.by_watchdog = (flags & kWatchdogs) != 0,
            .by_software = (flags & kSoftware) != 0,
            .by_pin = (flags & kPin) != 0,
            .by_power = (flags & (kPowerOn | kBrownOut)) != 0};
}

}  // namespace stator::stm32f4
