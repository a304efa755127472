// The bits of a float or double, and what needs nothing else: constants, tests, sign, order.
#pragma once

#include <bit>
#include <cfloat>
#include <concepts>
#include <cstdint>
#include <limits>

#if defined(__FAST_MATH__) || FLT_EVAL_METHOD != 0
#error "Stator's maths gives the same bits everywhere only without fast-math and excess precision"
#endif

namespace stator::math {

static_assert(std::numeric_limits<float>::is_iec559 && std::numeric_limits<double>::is_iec559);

// IEEE 754 binary32 and binary64: sign, biased exponent, fraction, from the most significant bit.
template <std::floating_point T>
struct FloatFormat;

template <>
struct FloatFormat<float> {
    using Bits = std::uint32_t;
    static constexpr int kFractionBits = 23;
    static constexpr int kExponentBias = 127;
    static constexpr Bits kSignBit = 0x80000000u;
    static constexpr Bits kExponentMask = 0x7f800000u;
    static constexpr Bits kFractionMask = 0x007fffffu;
};

template <>
struct FloatFormat<double> {
    using Bits = std::uint64_t;
    static constexpr int kFractionBits = 52;
    static constexpr int kExponentBias = 1023;
    static constexpr Bits kSignBit = 0x8000000000000000u;
    static constexpr Bits kExponentMask = 0x7ff0000000000000u;
    static constexpr Bits kFractionMask = 0x000fffffffffffffu;
};

template <std::floating_point T>
inline constexpr T kPi = static_cast<T>(0x1.921fb54442d18469898cc51701b8p+1L);
template <std::floating_point T>
inline constexpr T kTwoPi = T{2} * kPi<T>;
template <std::floating_point T>
inline constexpr T kHalfPi = kPi<T> / T{2};

template <std::floating_point T>
constexpr typename FloatFormat<T>::Bits to_bits(T x) {
    return std::bit_cast<typename FloatFormat<T>::Bits>(x);
}

template <std::floating_point T>
constexpr T from_bits(typename FloatFormat<T>::Bits bits) {
    return std::bit_cast<T>(bits);
}

template <std::floating_point T>
constexpr bool is_nan(T x) {
    using Format = FloatFormat<T>;
    return (to_bits(x) & ~Format::kSignBit) > Format::kExponentMask;
}

template <std::floating_point T>
constexpr bool is_finite(T x) {
    using Format = FloatFormat<T>;
    return (to_bits(x) & Format::kExponentMask) != Format::kExponentMask;
}

// The one NaN that is logged and hashed: quiet, positive, no payload.
template <std::floating_point T>
constexpr T canonical_nan() {
    using Format = FloatFormat<T>;
    return from_bits<T>(Format::kExponentMask | ((Format::kFractionMask + 1) >> 1));
}

// Any NaN as the canonical one; every other value as it is. x86 and Arm differ in the NaN that an
// invalid operation makes, so a value passes through here before its bits are looked at.
template <std::floating_point T>
constexpr T canonical(T x) {
    return is_nan(x) ? canonical_nan<T>() : x;
}

template <std::floating_point T>
constexpr T abs(T x) {
    return from_bits<T>(to_bits(x) & ~FloatFormat<T>::kSignBit);
}

template <std::floating_point T>
constexpr T copysign(T magnitude, T sign) {
    const auto mask = FloatFormat<T>::kSignBit;
    return from_bits<T>((to_bits(magnitude) & ~mask) | (to_bits(sign) & mask));
}

// -1, 0 or 1; 0 for both zeros and for a NaN.
template <std::floating_point T>
constexpr T sign(T x) {
    if (x > T{0}) return T{1};
    return x < T{0} ? T{-1} : T{0};
}

template <std::floating_point T>
constexpr T square(T x) {
    return x * x;
}

// Of two equal values, the first (so the sign of a zero is that of the first); the first, too, if
// either is a NaN.
template <std::floating_point T>
constexpr T min(T a, T b) {
    return b < a ? b : a;
}

template <std::floating_point T>
constexpr T max(T a, T b) {
    return b > a ? b : a;
}

// Nearest value in [low, high]; needs low <= high. A NaN stays one.
template <std::floating_point T>
constexpr T clamp(T x, T low, T high) {
    return min(max(x, low), high);
}

}  // namespace stator::math
