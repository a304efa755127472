// The 16-bit floating point of IEEE 754 (binary16), as it travels on the bus.
#pragma once

#include <cstdint>

namespace stator::dronecan {

// The nearest binary16, halfway cases away from zero as the protocol's other implementations do;
// finite values beyond its range become its largest. Not a number becomes 0x7FFF.
[[nodiscard]] uint16_t to_float16(float value);
[[nodiscard]] float from_float16(uint16_t bits);

}  // namespace stator::dronecan
