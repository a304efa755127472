// TIM4, which QEMU counts at 1 GHz: with -icount shift=0 once an instruction.
#pragma once

#include "stator/registers.hpp"

namespace stator::counter {

inline constexpr Register kControl(0x40000800);
inline constexpr Register kCount(0x40000824);
inline volatile uint32_t at_sink = 0;

}  // namespace stator::counter
