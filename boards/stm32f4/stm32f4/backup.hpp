// What a reset keeps: backup registers, and 4 KB of backup RAM (RM0090, 5.1.2 and 26.6.20). Both
// keep their content over every reset; over a loss of power only with a battery.
#pragma once

#include <cstddef>
#include <cstdint>

#include "stator/registers.hpp"
#include "stm32f4/clock_tree.hpp"

namespace stator::stm32f4 {

class BackupDomain {
  public:
    // Of the chip's 20: the first one is the mailbox of the PX4 bootloader, which stays there if it
    // finds 0xB007B007 (PX4-Bootloader, board_get_rtc_signature).
    static constexpr unsigned kRegisters = 19;
    static constexpr uint32_t kRam = 0x40024000;
    static constexpr size_t kRamBytes = 4096;

    // Before the first access; at start.
    void open() const {
        rcc::kApb1Enable.set(kPowerClock);
        kPowerControl.set(kWritable);
        rcc::kAhb1Enable.set(kBackupRamClock);
    }
    uint32_t read(unsigned index) const { return Register(kFirst + 4 * index).read(); }
    void write(unsigned index, uint32_t value) const { Register(kFirst + 4 * index).write(value); }

  private:
    static constexpr uint32_t kFirst = 0x40002854;         // RTC_BKP1R
    static constexpr Register kPowerControl{0x40007000};   // PWR_CR, 5.4.1
    static constexpr uint32_t kWritable = 1U << 8;         // DBP
    static constexpr uint32_t kPowerClock = 1U << 28;      // RCC_APB1ENR
    static constexpr uint32_t kBackupRamClock = 1U << 18;  // RCC_AHB1ENR
};

}  // namespace stator::stm32f4
