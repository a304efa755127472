// How far a computed value is from the true one.
#pragma once

#include <algorithm>

#include "stator/scalar.hpp"

namespace stator::math {

// Spacing of T's numbers at x, which is not below T's least normal number: there it is the least.
template <typename T>
double spacing(double x) {
    const std::uint64_t binade = to_bits(x) & FloatFormat<double>::kExponentMask;
    const std::uint64_t least = to_bits(static_cast<double>(std::numeric_limits<T>::min()));
    return from_bits<double>(std::max(binade, least)) *
           static_cast<double>(std::numeric_limits<T>::epsilon());
}

// |value - (high + low)| in units of the true value's last place: 0.5 at best, on a bad argument.
// The wrong kind of value (NaN, infinity) counts as a large error.
template <typename T>
double ulp_error(T value, double high, double low) {
    if (!is_finite(value)) return 1e30;
    return abs(((static_cast<double>(value) - high) - low) / spacing<T>(high));
}

}  // namespace stator::math
