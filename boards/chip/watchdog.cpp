#include "chip/watchdog.hpp"

#include "chip/chip.hpp"

namespace stator::chip {

namespace {

constexpr uint32_t kKey = 0x00, kPrescaler = 0x04, kReload = 0x08, kStatus = 0x0C;
constexpr Row kRows[] = {
    {kKey, "KR", 0, 0xFFFF},
    {kPrescaler, "PR", 0, 0x7},
    {kReload, "RLR", 0xFFF, 0xFFF},
    {kStatus, "SR", 0, 0, 0x3},
};
constexpr uint64_t kPeriod_ns = 31'250;          // of the oscillator, at its nominal 32 kHz
constexpr uint64_t kUpdate_ns = 5 * kPeriod_ns;  // 21.4.4
constexpr uint32_t kPrescalerUpdates = 1, kReloadUpdates = 2;

}  // namespace

Watchdog::Watchdog(Chip& chip)
    : Block(chip, "IWDG", 0x40003000, 0x400, kRows, {}, kHalfWordsAndWords) {}

void Watchdog::reset() {
    Block::reset();
    is_open_ = false;
    end_ns_ = updated_ns_ = kNever;
}

void Watchdog::run() {
    if (updated_ns_ <= chip_.now_ns()) {
        at(kStatus) = 0;
        updated_ns_ = kNever;
    }
    if (end_ns_ <= chip_.now_ns()) {
        end_ns_ = kNever;
        chip_.request_reset(ResetCause::kWatchdog);
    }
}

uint32_t Watchdog::on_read(uint32_t offset) {
    return offset == kKey ? 0 : at(offset);
}

void Watchdog::on_write(uint32_t offset, uint32_t value) {
    if (offset == kKey) {
        is_open_ = value == 0x5555;
        if (value == 0xAAAA) ++kicks_;
        if (value == 0xCCCC || (value == 0xAAAA && end_ns_ != kNever)) kick();
        return;
    }
    if (!is_open_) refuse(name_of(offset) + " is written while it is protected (21.4.1)");
    const uint32_t updates = offset == kPrescaler ? kPrescalerUpdates : kReloadUpdates;
    if (has(kStatus, updates)) refuse(name_of(offset) + " is written while it is updated (21.4.4)");
    at(offset) = value;
    at(kStatus) |= updates;
    updated_ns_ = chip_.now_ns() + kUpdate_ns;
}

void Watchdog::kick() {
    const uint64_t divider = 4ULL << std::min(at(kPrescaler), 6U);
    end_ns_ = chip_.now_ns() + (at(kReload) + 1ULL) * divider * kPeriod_ns;
}

}  // namespace stator::chip
