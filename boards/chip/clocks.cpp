#include "chip/clocks.hpp"

#include <algorithm>

#include "chip/chip.hpp"

namespace stator::chip {

namespace {

// RCC, 6.3
constexpr uint32_t kControl = 0x00, kPll = 0x04, kConfiguration = 0x08, kBackup = 0x70,
                   kStatus = 0x74;
constexpr uint32_t kHsiOn = 1U << 0, kHsiReady = 1U << 1, kHseOn = 1U << 16, kHseReady = 1U << 17,
                   kPllOn = 1U << 24, kPllReady = 1U << 25;
constexpr uint32_t kRemoveFlags = 1U << 24, kFlags = 0xFE000000;
constexpr Row kRccRows[] = {
    {kControl, "CR", 0x83, 0x010D00F9, 0x3E02FF02},
    {kPll, "PLLCFGR", 0x24003010, 0x0F437FFF},
    {kConfiguration, "CFGR", 0, 0xFFFFFCF3, 0x0000000C},
    {0x10, "AHB1RSTR", 0, 0x22E417FF},
    {0x14, "AHB2RSTR", 0, 0x000000F1},
    {0x18, "AHB3RSTR", 0, 0x00000001},
    {0x20, "APB1RSTR", 0, 0xF6FEC9FF},
    {0x24, "APB2RSTR", 0, 0x04777933},
    {0x30, "AHB1ENR", 0x00100000, 0x7EF417FF},
    {0x34, "AHB2ENR", 0, 0x000000F1},
    {0x38, "AHB3ENR", 0, 0x00000001},
    {0x40, "APB1ENR", 0, 0xF6FEC9FF},
    {0x44, "APB2ENR", 0, 0x04777F33},
    {kBackup, "BDCR", 0, 0x00018305, 0x00000002},
    {kStatus, "CSR", 0x0E000000, 0x01000001, 0xFE000002},
};
constexpr uint32_t kHsi_hz = 16'000'000;
// Data sheet DS9405: tables of HSE (2 ms) and PLL characteristics (300 us at most).
constexpr uint64_t kCrystalStart_ns = 2'000'000, kPllStart_ns = 200'000, kHsiStart_ns = 4'000;
constexpr uint32_t kMaxApb1_hz = 45'000'000, kMaxApb2_hz = 90'000'000;

uint32_t field(uint32_t value, unsigned first, unsigned bits) {
    return value >> first & ((1U << bits) - 1);
}
// HPRE and PPRE: the divider.
uint32_t ahb_divider(uint32_t code) {
    constexpr uint32_t kDividers[] = {2, 4, 8, 16, 64, 128, 256, 512};
    return code < 8 ? 1 : kDividers[code - 8];
}
uint32_t apb_divider(uint32_t code) {
    return code < 4 ? 1 : 2U << (code - 4);
}

// PWR, 5.4 (F42x)
constexpr uint32_t kPowerControl = 0x00;
constexpr uint32_t kVoltageScale = 3U << 14;
constexpr Row kPowerRows[] = {
    {kPowerControl, "CR", 0x0000C000, 0x000FEFFF},
    {0x04, "CSR", 0x00004000, 0x000C0300, 0x0003400F},
};

// FLASH, 3.9
constexpr uint32_t kAccess = 0x00;
constexpr Row kFlashRows[] = {
    {kAccess, "ACR", 0, 0x00001F0F},
    {0x0C, "SR", 0, 0x000000F2, 0x00010000},
    {0x10, "CR", 0x80000000, 0x830183FF},
    {0x14, "OPTCR", 0x0FFFAAED, 0, 0xFFFFFFFF},
};

}  // namespace

PowerControl::PowerControl(Chip& chip)
    : Block(chip, "PWR", 0x40007000, 0x400, kPowerRows, {0x40, 28}, kHalfWordsAndWords) {}

bool PowerControl::is_backup_writable() const {
    return has(kPowerControl, 1U << 8);
}

uint32_t PowerControl::max_core_hz() const {
    constexpr uint32_t kMax_hz[] = {0, 120'000'000, 144'000'000, 168'000'000};
    return kMax_hz[field(at(kPowerControl), 14, 2)];
}

void PowerControl::on_write(uint32_t offset, uint32_t value) {
    if (offset == kPowerControl) {
        const uint32_t changed = at(offset) ^ value;
        if ((changed & kVoltageScale) != 0 && chip_.reset_and_clocks().is_pll_on()) {
            refuse("the voltage scale changes while the PLL is on (5.4.1)");
        }
        if (field(value, 14, 2) == 0) refuse("the voltage scale is the reserved one (5.4.1)");
        if ((value & 0x30000) != 0) refuse("over-drive is not modelled");
    }
    at(offset) = value;
}

FlashControl::FlashControl(Chip& chip)
    : Block(chip, "FLASH", 0x40023C00, 0x400, kFlashRows, {}, kWords) {}

uint32_t FlashControl::max_core_hz() const {
    return (field(at(kAccess), 0, 4) + 1) * 30'000'000;  // table 11
}

void FlashControl::on_write(uint32_t offset, uint32_t value) {
    if (offset != kAccess) refuse("programming is not modelled");
    const uint32_t caches = at(offset) | value;
    if (((value & 1U << 11) != 0 && (caches & 1U << 9) != 0) ||
        ((value & 1U << 12) != 0 && (caches & 1U << 10) != 0)) {
        refuse("a cache is reset while it is on (3.9.1)");
    }
    at(offset) = value;
    chip_.reset_and_clocks().check_flash();
}

ResetAndClocks::ResetAndClocks(Chip& chip, uint32_t crystal_hz, const PowerControl& power,
                               const FlashControl& flash)
    : Block(chip, "RCC", 0x40023800, 0x400, kRccRows, {}, kAllWidths),
      crystal_hz_(crystal_hz),
      power_(power),
      flash_(flash),
      sources_{{kHsiOn, kHsiReady, kHsiStart_ns},
               {kHseOn, kHseReady, kCrystalStart_ns},
               {kPllOn, kPllReady, kPllStart_ns}} {}

void ResetAndClocks::reset() {
    const uint32_t kept = at(kBackup);
    const uint32_t flags = at(kStatus);
    Block::reset();
    at(kBackup) = kept;
    at(kStatus) = flags;
    clocks_ = {};
    for (Source& source : sources_) source.ready_ns = kNever;
}

void ResetAndClocks::note_reset(ResetCause cause) {
    at(kStatus) |= static_cast<uint32_t>(cause);
}

bool ResetAndClocks::is_on(Gate gate) const {
    return gate.offset == 0 || has(gate.offset, 1U << gate.bit);
}

bool ResetAndClocks::is_pll_on() const {
    return has(kControl, kPllOn);
}

uint64_t ResetAndClocks::due_ns() const {
    return std::min({sources_[0].ready_ns, sources_[1].ready_ns, sources_[2].ready_ns});
}

void ResetAndClocks::run() {
    for (Source& source : sources_) {
        if (source.ready_ns > chip_.now_ns()) continue;
        at(kControl) |= source.ready;
        source.ready_ns = kNever;
    }
}

uint32_t ResetAndClocks::on_read(uint32_t offset) {
    if (offset != kConfiguration) return at(offset);
    return (at(offset) & ~0xCU) | field(at(offset), 0, 2) << 2;
}

void ResetAndClocks::on_write(uint32_t offset, uint32_t value) {
    switch (offset) {
        case kControl:
            control(value);
            return;
        case kPll:
            if (value != at(kPll) && is_pll_on()) refuse("PLLCFGR changes while the PLL is on");
            break;
        case kConfiguration:
            configure(value);
            return;
        case 0x10:
        case 0x14:
        case 0x18:
        case 0x20:
        case 0x24:
            if (value != 0) refuse("the reset of a peripheral is not modelled");
            break;
        case kStatus:
            if ((value & kRemoveFlags) != 0) value &= ~(kFlags | kRemoveFlags);
            break;
        default:
            break;
    }
    at(offset) = value;
}

void ResetAndClocks::control(uint32_t value) {
    constexpr uint32_t kUsed[] = {kHsiOn, kHseOn, kPllOn};
    const uint32_t source = field(at(kConfiguration), 0, 2);
    if ((value & kUsed[source]) == 0) refuse("the clock that the core runs on is switched off");
    if (source == 2 && (value & (field(at(kPll), 22, 1) != 0 ? kHseOn : kHsiOn)) == 0) {
        refuse("the clock of the PLL that the core runs on is switched off");
    }
    if ((value & kPllOn) != 0 && !is_pll_on()) check_pll(value);
    const uint32_t before = at(kControl);
    for (Source& changed : sources_) {
        if (((before ^ value) & changed.on) == 0) continue;
        value &= ~changed.ready;
        const bool starts = (value & changed.on) != 0 && (changed.on != kHseOn || crystal_hz_ != 0);
        changed.ready_ns = starts ? chip_.now_ns() + changed.start_ns : kNever;
    }
    at(kControl) = value;
}

void ResetAndClocks::check_pll(uint32_t value) const {
    const bool is_crystal = field(at(kPll), 22, 1) != 0;
    if ((value & (is_crystal ? kHseReady : kHsiReady)) == 0) {
        refuse("the PLL starts from a clock that is not ready");
    }
    const uint32_t divider = field(at(kPll), 0, 6);
    if (divider < 2) refuse("PLLM is below 2 (6.3.2)");
    const uint32_t input_hz = (is_crystal ? crystal_hz_ : kHsi_hz) / divider;
    if (input_hz < 950'000 || input_hz > 2'100'000) refuse("the PLL's input is not 1 to 2 MHz");
    const uint32_t factor = field(at(kPll), 6, 9);
    const uint64_t oscillator_hz = static_cast<uint64_t>(input_hz) * factor;
    if (factor < 50 || factor > 432 || oscillator_hz < 100'000'000 || oscillator_hz > 432'000'000) {
        refuse("the PLL's oscillator is not 100 to 432 MHz");
    }
    if (field(at(kPll), 24, 4) < 2) refuse("PLLQ is below 2 (6.3.2)");
}

uint32_t ResetAndClocks::pll_hz() const {
    const uint32_t input_hz = field(at(kPll), 22, 1) != 0 ? crystal_hz_ : kHsi_hz;
    const uint64_t oscillator_hz =
        static_cast<uint64_t>(input_hz) * field(at(kPll), 6, 9) / field(at(kPll), 0, 6);
    return static_cast<uint32_t>(oscillator_hz / (2 * field(at(kPll), 16, 2) + 2));
}

uint32_t ResetAndClocks::switched_hz(uint32_t configuration) const {
    switch (field(configuration, 0, 2)) {
        case 0:
            if (!has(kControl, kHsiReady)) refuse("switched to HSI, which is not ready");
            return kHsi_hz;
        case 1:
            if (!has(kControl, kHseReady)) refuse("switched to HSE, which is not ready");
            return crystal_hz_;
        case 2:
            if (!has(kControl, kPllReady)) refuse("switched to the PLL, which is not ready");
            return pll_hz();
        default:
            refuse("switched to the reserved clock (6.3.3)");
    }
}

void ResetAndClocks::configure(uint32_t value) {
    const uint32_t core_hz = switched_hz(value) / ahb_divider(field(value, 4, 4));
    const uint32_t apb1 = apb_divider(field(value, 10, 3));
    const uint32_t apb2 = apb_divider(field(value, 13, 3));
    if (core_hz > power_.max_core_hz()) refuse("the core clock is above the voltage scale's");
    if (core_hz / apb1 > kMaxApb1_hz) refuse("APB1 is above 45 MHz");
    if (core_hz / apb2 > kMaxApb2_hz) refuse("APB2 is above 90 MHz");
    chip_.clocks_change();
    at(kConfiguration) = value;
    clocks_ = {.core_hz = core_hz,
               .apb1_hz = core_hz / apb1,
               .apb2_hz = core_hz / apb2,
               .apb1_timer_hz = core_hz / apb1 * (apb1 == 1 ? 1 : 2),
               .apb2_timer_hz = core_hz / apb2 * (apb2 == 1 ? 1 : 2)};
    check_flash();
}

void ResetAndClocks::check_flash() const {
    if (clocks_.core_hz > flash_.max_core_hz()) {
        refuse("the core clock is above what the flash's wait states allow (3.5.1)");
    }
}

}  // namespace stator::chip
