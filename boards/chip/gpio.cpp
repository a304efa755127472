#include "chip/gpio.hpp"

#include <array>

#include "chip/chip.hpp"

namespace stator::chip {

namespace {

constexpr uint32_t kMode = 0x00, kType = 0x04, kSpeed = 0x08, kPull = 0x0C, kInput = 0x10,
                   kOutput = 0x14, kSetReset = 0x18, kLock = 0x1C;
// At reset the pins of the debugger have their function: 8.3.1.
constexpr auto rows(uint32_t mode, uint32_t speed, uint32_t pull) {
    return std::array{
        Row{kMode, "MODER", mode, 0xFFFFFFFF},     Row{kType, "OTYPER", 0, 0xFFFF},
        Row{kSpeed, "OSPEEDR", speed, 0xFFFFFFFF}, Row{kPull, "PUPDR", pull, 0xFFFFFFFF},
        Row{kInput, "IDR", 0, 0, 0xFFFF},          Row{kOutput, "ODR", 0, 0xFFFF},
        Row{kSetReset, "BSRR", 0, 0xFFFFFFFF},     Row{kLock, "LCKR", 0, 0x1FFFF},
        Row{0x20, "AFR", 0, 0xFFFFFFFF, 0, 2},
    };
}
constexpr auto kPortA = rows(0xA8000000, 0x0C000000, 0x64000000);
constexpr auto kPortB = rows(0x00000280, 0x000000C0, 0x00000100);
constexpr auto kOtherPort = rows(0, 0, 0);

std::span<const Row> rows_of(char port) {
    if (port == 'A') return kPortA;
    return port == 'B' ? kPortB : kOtherPort;
}

constexpr unsigned kOutputMode = 1, kAlternateMode = 2;

}  // namespace

Gpio::Gpio(Chip& chip, char port, Exti& exti)
    : Block(chip, std::string("GPIO") + port,
            0x40020000U + 0x400U * static_cast<unsigned>(port - 'A'), 0x400, rows_of(port),
            {0x30, static_cast<unsigned>(port - 'A')}, kAllWidths),
      port_(port),
      first_(pin(port, 0)) {
    for (unsigned number = 0; number < 16; ++number) {
        const unsigned watched = first_ + number;
        chip.pins().watch(watched, [&exti, watched](bool is_high) { exti.edge(watched, is_high); });
    }
}

void Gpio::reset() {
    Block::reset();
    drive();
}

unsigned Gpio::mode(unsigned number) const {
    return at(kMode) >> 2 * number & 3;
}

uint32_t Gpio::on_read(uint32_t offset) {
    if (offset == kSetReset) return 0;
    if (offset != kInput) return at(offset);
    uint32_t levels = 0;
    for (unsigned i = 0; i < 16; ++i) {
        levels |= (chip_.pins().is_high(first_ + i) ? 1U : 0U) << i;
    }
    return levels;
}

void Gpio::on_write(uint32_t offset, uint32_t value) {
    if (offset == kSpeed && port_ == 'C' && value >> 26 != 0) {
        refuse("PC13 to PC15 are set to more than 2 MHz (5.1.2)");
    }
    if (offset == kSetReset) {
        // Set wins over reset: 8.4.7.
        at(kOutput) = ((at(kOutput) & ~(value >> 16)) | value) & 0xFFFF;
    } else if (offset == kLock) {
        refuse("the lock is not modelled");
    } else {
        at(offset) = value;
    }
    drive();
}

// An alternate function drives its pin in the model of its peripheral.
void Gpio::drive() {
    for (unsigned i = 0; i < 16; ++i) {
        const uint32_t pull = at(kPull) >> 2 * i & 3;
        if (pull == 3) refuse("PUPDR has the reserved value (8.4.4)");
        Drive drive = pull == 1 ? Drive::kPullUp : pull == 2 ? Drive::kPullDown : Drive::kNone;
        const bool is_open_drain = (at(kType) >> i & 1) != 0;
        if (mode(i) == kOutputMode) {
            const bool is_high = (at(kOutput) >> i & 1) != 0;
            if (!is_high) drive = Drive::kLow;
            if (is_high && !is_open_drain) drive = Drive::kHigh;
        }
        if (mode(i) == kAlternateMode && !is_open_drain) drive = Drive::kPullUp;
        chip_.pins().set_inside(first_ + i, drive);
    }
}

}  // namespace stator::chip
