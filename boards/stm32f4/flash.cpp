// Unlocks, erases or programs, waits, and locks again.
#include "flash.hpp"

#include "wait.hpp"

namespace stator::stm32f4 {

namespace {

constexpr Register kKey(0x40023C04);      // FLASH_KEYR, 3.9.2
constexpr Register kStatus(0x40023C0C);   // FLASH_SR, 3.9.4
constexpr Register kControl(0x40023C10);  // FLASH_CR, 3.9.5
constexpr uint32_t kKey1 = 0x45670123;
constexpr uint32_t kKey2 = 0xCDEF89AB;
constexpr uint32_t kWriteProtected = 1U << 4;
constexpr uint32_t kErrors = 0xF0;
constexpr uint32_t kBusy = 1U << 16;
constexpr uint32_t kProgram = 1U << 0;
constexpr uint32_t kErase = 1U << 1;
constexpr uint32_t kSectorShift = 3;
constexpr uint32_t kWords = 2U << 8;  // 32 bits at a time
constexpr uint32_t kStart = 1U << 16;
constexpr uint32_t kLock = 1U << 31;

// A word takes at most 100 us, a sector of 128 KB at most 2 s (data sheet, flash characteristics);
// a read takes at least 2 of 168 cycles a microsecond.
constexpr uint32_t kMaxProgramReads = 20'000;
constexpr uint32_t kMaxEraseReads = 400'000'000;

FlashStatus outcome(uint32_t most_reads) {
    if (!wait_until(kStatus, kBusy, 0, most_reads)) return FlashStatus::kBusy;
    const uint32_t errors = kStatus.read() & kErrors;
    kStatus.write(errors);  // cleared by writing 1
    if ((errors & kWriteProtected) != 0) return FlashStatus::kProtected;
    return errors == 0 ? FlashStatus::kDone : FlashStatus::kFailed;
}

FlashStatus begin() {
    if (!wait_until(kStatus, kBusy, 0, kMaxProgramReads)) return FlashStatus::kBusy;
    if ((kControl.read() & kLock) != 0) {
        kKey.write(kKey1);
        kKey.write(kKey2);
    }
    kStatus.write(kErrors);  // what an earlier operation left
    return FlashStatus::kDone;
}

}  // namespace

FlashStatus erase_sector(uint32_t sector) {
    if (const FlashStatus ready = begin(); ready != FlashStatus::kDone) return ready;
    kControl.write(kErase | sector << kSectorShift | kWords);
    kControl.set(kStart);
    const FlashStatus status = outcome(kMaxEraseReads);
    kControl.write(kLock);
    return status;
}

FlashStatus program_word(uint32_t address, uint32_t value) {
    if (const FlashStatus ready = begin(); ready != FlashStatus::kDone) return ready;
    kControl.write(kProgram | kWords);
    Register(address).write(value);
    const FlashStatus status = outcome(kMaxProgramReads);
    kControl.write(kLock);
    return status;
}

}  // namespace stator::stm32f4
