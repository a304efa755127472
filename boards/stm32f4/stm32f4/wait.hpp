// The one way to wait for a hardware flag: with a bound, and an outcome that the caller must see.
#pragma once

#include <cstdint>

#include "stator/registers.hpp"

namespace stator::stm32f4 {

// Reads until the bits of `mask` have `value`, at most `most_reads` times (a read of a peripheral
// takes at least 2 core cycles). False: they never had it.
[[nodiscard]] inline bool wait_until(Register reg, uint32_t mask, uint32_t value,
                                     uint32_t most_reads) {
    for (uint32_t reads = 0; reads < most_reads; ++reads) {
        if ((reg.read() & mask) == value) return true;
    }
    return false;
}

}  // namespace stator::stm32f4
