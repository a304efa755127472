// Writes the chip's own flash (RM0090, 3.6 and 3.9): for parameters, on the ground. An erase stops
// every fetch from the same bank for up to 2 s, so never while armed.
#pragma once

#include <cstdint>

#include "stator/registers.hpp"

namespace stator::stm32f4 {

enum class FlashStatus {
    kDone,
    kBusy,       // the last operation did not end within its bound
    kProtected,  // the sector is write-protected
    kFailed,     // the hardware reports an alignment, parallelism or sequence error
};

// Erases sector 0 to 11 of the first bank. Supply 2.7 to 3.6 V.
[[nodiscard]] FlashStatus erase_sector(uint32_t sector);

// Programs one erased word. `address` is a multiple of 4.
[[nodiscard]] FlashStatus program_word(uint32_t address, uint32_t value);

}  // namespace stator::stm32f4
