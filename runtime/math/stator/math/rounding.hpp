// From real numbers to whole ones: floor, ceil, trunc, round, and the one conversion to an integer.
#pragma once

#include "stator/math/bits.hpp"

namespace stator::math {

// Towards zero, saturating: what lies beyond Int's range gives its nearest end, a NaN gives 0. The
// only way from floating point to an integer: the plain cast is undefined there, and x86 and Arm
// do differ.
template <std::integral Int, std::floating_point T>
constexpr Int saturate(T x) {
    using Limits = std::numeric_limits<Int>;
    static_assert(Limits::digits < std::numeric_limits<T>::max_exponent);
    // The largest Int need not be a T; one more than it, a power of two, is.
    constexpr T kAbove = static_cast<T>(Limits::max() / 2 + 1) * T{2};
    constexpr T kLowest = static_cast<T>(Limits::min());
    if (x >= kAbove) return Limits::max();
    if (x <= kLowest) return Limits::min();
    return is_nan(x) ? Int{0} : static_cast<Int>(x);
}

// Towards zero, as a floating-point value; exact for all x, keeps the sign of a zero result. From
// 2^23 (float) or 2^52 (double) on every value is whole.
inline float trunc(float x) {
    if (!(abs(x) < 0x1p23F)) return x;
    return copysign(static_cast<float>(static_cast<std::int32_t>(x)), x);
}

inline double trunc(double x) {
    if (!(abs(x) < 0x1p52)) return x;
    return copysign(static_cast<double>(static_cast<std::int64_t>(x)), x);
}

template <std::floating_point T>
inline T floor(T x) {
    const T whole = trunc(x);
    return whole > x ? whole - T{1} : whole;
}

template <std::floating_point T>
inline T ceil(T x) {
    const T whole = trunc(x);
    return whole < x ? copysign(whole + T{1}, x) : whole;
}

// To the nearest whole number, halves away from zero.
template <std::floating_point T>
inline T round(T x) {
    const T whole = trunc(x);
    return abs(x - whole) >= T{0.5} ? whole + copysign(T{1}, x) : whole;
}

}  // namespace stator::math
