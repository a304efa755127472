// What a floating-point field of a message may hold.
#pragma once

namespace stator::dronecan {

// False for a value outside the physical range, infinity included: then the sender is not to be
// trusted. NaN is how DroneCAN's types say "unknown": it is possible, and the other fields count.
[[nodiscard]] constexpr bool is_possible(float value, float min, float max) {
    return !(value < min || value > max);  // NaN compares false
}

}  // namespace stator::dronecan
