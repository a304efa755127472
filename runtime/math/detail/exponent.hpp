// The exponent of a floating-point number, read and written as bits.
#pragma once

#include "stator/math/bits.hpp"

namespace stator::math::detail {

// The whole number nearest to x, the even one of two: adding and taking away 1.5 * 2^fraction bits
// leaves no room for a fraction. |x| below a quarter of that.
template <std::floating_point T>
constexpr T nearest(T x) {
    constexpr T kShift = T{1.5} / std::numeric_limits<T>::epsilon();
    return (x + kShift) - kShift;
}

// 2^n; n within the exponents of normal numbers.
template <std::floating_point T>
constexpr T power_of_two(int n) {
    using Format = FloatFormat<T>;
    using Bits = typename Format::Bits;
    return from_bits<T>(static_cast<Bits>(n + Format::kExponentBias) << Format::kFractionBits);
}

// |x| as integer * 2^exponent, with the leading bit of the integer at kFractionBits. x is finite,
// not 0.
template <std::floating_point T>
struct Decomposed {
    typename FloatFormat<T>::Bits integer;
    int exponent;
};

template <std::floating_point T>
constexpr Decomposed<T> decompose(T x) {
    using Format = FloatFormat<T>;
    const auto bits = to_bits(abs(x));
    const auto fraction = bits & Format::kFractionMask;
    const int biased = static_cast<int>(bits >> Format::kFractionBits);
    constexpr int kOffset = Format::kExponentBias + Format::kFractionBits;
    if (biased != 0) return {fraction | (Format::kFractionMask + 1), biased - kOffset};
    const int shift = std::countl_zero(fraction) - std::countl_zero(Format::kFractionMask + 1);
    return {fraction << shift, 1 - kOffset - shift};
}

}  // namespace stator::math::detail
