// How far a computed value is from the true one, and how far it may be.
#pragma once

#include <algorithm>

#include "stator/scalar.hpp"

namespace stator::math {

// Largest errors allowed, in both types: the largest ever seen (runtime/math/README.md), and a
// little more, because no test tries every argument.
namespace limit {
inline constexpr double kSin = 0.80;
inline constexpr double kCos = 0.80;
inline constexpr double kTan = 0.94;
inline constexpr double kWrapPi = 0.52;
inline constexpr double kAtan = 0.70;
inline constexpr double kAtan2 = 0.72;
inline constexpr double kAsin = 0.69;
inline constexpr double kAcos = 0.69;
inline constexpr double kExp = 0.78;
inline constexpr double kLog = 0.87;
inline constexpr double kPow = 0.79;
inline constexpr double kSqrt = 0.501;  // 0.5, and the rounding of the measurement
}  // namespace limit

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
