// Exact remainders by long division in binary.
#include "detail/exponent.hpp"
#include "stator/scalar.hpp"

namespace stator::math {

namespace {

template <typename T>
struct Division {
    T rest;             // |x| modulo |y|
    bool odd_quotient;  // of trunc(|x| / |y|)
};

// Both finite, y not 0.
template <typename T>
Division<T> divide(T x, T y) {
    if (abs(x) < abs(y)) return {abs(x), false};
    using Format = FloatFormat<T>;
    auto [rest, exponent] = detail::decompose(x);
    const auto [divisor, lowest] = detail::decompose(y);
    bool odd = rest >= divisor;
    if (odd) rest -= divisor;
    for (; exponent > lowest; --exponent) {
        rest <<= 1;
        odd = rest >= divisor;
        if (odd) rest -= divisor;
    }
    // rest * 2^lowest. Below, the number of shifts that keep `lowest` in the normal range.
    constexpr int kMin = 1 - Format::kExponentBias;
    const int scale = lowest < kMin ? kMin : lowest;
    const T value = static_cast<T>(rest) * detail::power_of_two<T>(scale);
    return {lowest < kMin ? value * detail::power_of_two<T>(lowest - kMin) : value, odd};
}

template <typename T>
bool has_remainder(T x, T y) {
    return is_finite(x) && !is_nan(y) && y != T{0};
}

template <typename T>
T fmod_of(T x, T y) {
    if (!has_remainder(x, y)) return canonical_nan<T>();
    if (!is_finite(y)) return x;
    return copysign(divide(x, y).rest, x);
}

template <typename T>
T remainder_of(T x, T y) {
    if (!has_remainder(x, y)) return canonical_nan<T>();
    if (!is_finite(y)) return x;
    const T size = abs(y);
    const Division<T> division = divide(x, y);
    const T to_next = size - division.rest;
    const bool up = division.rest > to_next || (division.rest == to_next && division.odd_quotient);
    const T magnitude = up ? -to_next : division.rest;
    return (to_bits(x) & FloatFormat<T>::kSignBit) != 0 ? -magnitude : magnitude;
}

}  // namespace

float fmod(float x, float y) {
    return fmod_of(x, y);
}
double fmod(double x, double y) {
    return fmod_of(x, y);
}
float remainder(float x, float y) {
    return remainder_of(x, y);
}
double remainder(double x, double y) {
    return remainder_of(x, y);
}

}  // namespace stator::math
