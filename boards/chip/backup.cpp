#include "chip/backup.hpp"

namespace stator::chip {

namespace {

constexpr Row kRegisters[] = {{0x50, "BKPR", 0, 0xFFFFFFFF, 0, 20}};
constexpr Row kRam[] = {{0x00, "word ", 0, 0xFFFFFFFF, 0, 1024}};

}  // namespace

Backup::Backup(Chip& chip, const PowerControl& power)
    : Block(chip, "RTC", 0x40002800, 0x400, kRegisters, {}, kWords), power_(power) {}

void Backup::on_write(uint32_t offset, uint32_t value) {
    if (!power_.is_backup_writable()) refuse("written while DBP of PWR_CR is 0 (5.1.2)");
    at(offset) = value;
}

BackupRam::BackupRam(Chip& chip, const PowerControl& power)
    : Block(chip, "BKPSRAM", 0x40024000, 0x1000, kRam, {0x30, 18}, kAllWidths), power_(power) {}

void BackupRam::on_write(uint32_t offset, uint32_t value) {
    if (!power_.is_backup_writable()) refuse("written while DBP of PWR_CR is 0 (5.1.2)");
    at(offset) = value;
}

}  // namespace stator::chip
