// Angles from their sine, cosine or tangent.
#include "detail/coefficients.hpp"
#include "detail/polynomial.hpp"
#include "stator/scalar.hpp"

namespace stator::math {

namespace {

using detail::Coefficients;
using detail::DoubleWord;

// a / b in [0, 1], brought to where products neither overflow nor underflow, if they are not so far
// apart that one of them would; then its exact value does not matter.
template <typename T>
struct Ratio {
    T a;
    T b;
};

template <typename T>
Ratio<T> scaled(T a, T b) {
    constexpr bool kIsFloat = std::numeric_limits<T>::digits == 24;
    constexpr T kLarge = kIsFloat ? T{0x1p40} : static_cast<T>(0x1p400);
    constexpr T kShrink = kIsFloat ? T{0x1p-80} : static_cast<T>(0x1p-800);
    constexpr T kGrow = kIsFloat ? T{0x1p100} : static_cast<T>(0x1p900);
    if (b > kLarge) return {a * kShrink, b * kShrink};
    if (b < T{1} / kLarge) return {a * kGrow, b * kGrow};
    return {a, b};
}

// atan(a / b) for 0 <= a <= b, not both 0. Beyond tan(pi/8), atan(t) = pi/4 + atan((t-1)/(t+1)).
template <typename T>
DoubleWord<T> atan_of_ratio(T a, T b) {
    constexpr T kTiny = std::numeric_limits<T>::digits == 24 ? T{0x1p-13} : T{0x1p-27};
    constexpr T kTanEighth = static_cast<T>(0.41421356237309503);
    if (a < kTiny * b) return {a / b, T{0}};
    const Ratio<T> ratio = scaled(a, b);
    const bool upper = ratio.a > kTanEighth * ratio.b;
    const DoubleWord<T> above =
        upper ? detail::two_sum(ratio.a, -ratio.b) : DoubleWord<T>{ratio.a, T{0}};
    const DoubleWord<T> below =
        upper ? detail::two_sum(ratio.b, ratio.a) : DoubleWord<T>{ratio.b, T{0}};
    const DoubleWord<T> t = detail::divide(above, below);
    const T z = square(t.high);
    const T cubic = t.high * z * detail::polynomial(z, Coefficients<T>::kAtan);
    const DoubleWord<T> angle = detail::fast_two_sum(t.high, cubic + t.low);
    return upper ? detail::add(Coefficients<T>::kQuarterPi, angle) : angle;
}

template <typename T>
DoubleWord<T> minus(DoubleWord<T> a, DoubleWord<T> b) {
    return detail::add(a, DoubleWord<T>{-b.high, -b.low});
}

template <typename T>
T atan2_of(T y, T x) {
    if (is_nan(y) || is_nan(x)) return canonical_nan<T>();
    T a = abs(y);
    T b = abs(x);
    // Infinities and zeros have the angle of these.
    if (!is_finite(a) && !is_finite(b)) a = b = T{1};
    const bool steep = a > b;
    DoubleWord<T> angle{T{0}, T{0}};
    if (a > T{0}) angle = steep ? atan_of_ratio(b, a) : atan_of_ratio(a, b);
    if (steep) angle = minus(Coefficients<T>::kHalfPi, angle);
    if (copysign(T{1}, x) < T{0}) angle = minus(Coefficients<T>::kPi, angle);
    return copysign(angle.high, y);
}

// asin for |x| <= 1/2: x + x^3 P(x^2).
template <typename T>
T asin_rest(T x) {
    const T z = square(x);
    return x * z * detail::polynomial(z, Coefficients<T>::kAsin);
}

// acos(x) / 2 = asin(sqrt((1 - x) / 2)) for x in [1/2, 1].
template <typename T>
DoubleWord<T> half_acos(T x) {
    const T z = T{0.5} * (T{1} - x);
    const T root = sqrt(z);
    if (root == T{0}) return {T{0}, T{0}};
    const DoubleWord<T> squared = detail::two_product(root, root);
    const T root_low = ((z - squared.high) - squared.low) / (T{2} * root);
    return detail::fast_two_sum(root, root_low + asin_rest(root));
}

template <typename T>
DoubleWord<T> twice(DoubleWord<T> x) {
    return {T{2} * x.high, T{2} * x.low};
}

template <typename T>
T asin_of(T x) {
    const T magnitude = abs(x);
    if (!(magnitude <= T{1})) return canonical_nan<T>();
    if (magnitude <= T{0.5}) return x + asin_rest(x);
    const DoubleWord<T> angle = minus(Coefficients<T>::kHalfPi, twice(half_acos(magnitude)));
    return copysign(angle.high, x);
}

template <typename T>
T acos_of(T x) {
    const T magnitude = abs(x);
    if (!(magnitude <= T{1})) return canonical_nan<T>();
    if (magnitude <= T{0.5}) {
        const DoubleWord<T> angle = detail::fast_two_sum(x, asin_rest(x));
        return minus(Coefficients<T>::kHalfPi, angle).high;
    }
    const DoubleWord<T> angle = twice(half_acos(magnitude));
    return x > T{0} ? angle.high : minus(Coefficients<T>::kPi, angle).high;
}

}  // namespace

float atan2(float y, float x) {
    return atan2_of(y, x);
}
double atan2(double y, double x) {
    return atan2_of(y, x);
}
float atan(float x) {
    return atan2_of(x, 1.0F);
}
double atan(double x) {
    return atan2_of(x, 1.0);
}
float asin(float x) {
    return asin_of(x);
}
double asin(double x) {
    return asin_of(x);
}
float acos(float x) {
    return acos_of(x);
}
double acos(double x) {
    return acos_of(x);
}

}  // namespace stator::math
