// Numbers of twice the precision: the unevaluated sum of two floating-point numbers (Dekker 1971).
// Right only if the compiler neither reorders nor contracts.
#pragma once

#include "stator/math/bits.hpp"

namespace stator::math::detail {

// |low| is at most about half a unit in the last place of high.
template <std::floating_point T>
struct DoubleWord {
    T high;
    T low;
};

// Exact a + b, if |a| >= |b| or a is 0.
template <std::floating_point T>
constexpr DoubleWord<T> fast_two_sum(T a, T b) {
    const T sum = a + b;
    return {sum, b - (sum - a)};
}

// Exact a + b (Knuth).
template <std::floating_point T>
constexpr DoubleWord<T> two_sum(T a, T b) {
    const T sum = a + b;
    const T b_part = sum - a;
    const T a_part = sum - b_part;
    return {sum, (a - a_part) + (b - b_part)};
}

// Two halves with half the digits each (Veltkamp), so that their products are exact.
template <std::floating_point T>
constexpr DoubleWord<T> split(T x) {
    constexpr int kHalf = (std::numeric_limits<T>::digits + 1) / 2;
    constexpr T kFactor = static_cast<T>((1 << kHalf) + 1);
    const T scaled = kFactor * x;
    const T high = scaled - (scaled - x);
    return {high, x - high};
}

// Exact a * b, if nothing overflows or underflows: it has no fused multiply-add to rely on.
template <std::floating_point T>
constexpr DoubleWord<T> two_product(T a, T b) {
    const DoubleWord<T> x = split(a);
    const DoubleWord<T> y = split(b);
    const T product = a * b;
    const T error = ((x.high * y.high - product) + x.high * y.low + x.low * y.high) + x.low * y.low;
    return {product, error};
}

// The following are good to a few units of the squared precision.
template <std::floating_point T>
constexpr DoubleWord<T> add(DoubleWord<T> a, DoubleWord<T> b) {
    const DoubleWord<T> sum = two_sum(a.high, b.high);
    return fast_two_sum(sum.high, sum.low + (a.low + b.low));
}

template <std::floating_point T>
constexpr DoubleWord<T> multiply(DoubleWord<T> a, DoubleWord<T> b) {
    const DoubleWord<T> product = two_product(a.high, b.high);
    return fast_two_sum(product.high, product.low + (a.high * b.low + a.low * b.high));
}

template <std::floating_point T>
constexpr DoubleWord<T> divide(DoubleWord<T> a, DoubleWord<T> b) {
    const T quotient = a.high / b.high;
    const DoubleWord<T> product = two_product(quotient, b.high);
    const T rest = ((a.high - product.high) - product.low) + (a.low - quotient * b.low);
    return fast_two_sum(quotient, rest / b.high);
}

}  // namespace stator::math::detail
