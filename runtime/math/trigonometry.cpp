// Sine, cosine, tangent, and angles wrapped to one turn.
#include "detail/coefficients.hpp"
#include "detail/polynomial.hpp"
#include "detail/reduction.hpp"
#include "stator/scalar.hpp"

namespace stator::math {

namespace {

using detail::Coefficients;
using detail::DoubleWord;
using detail::ReducedAngle;

// Such an angle needs no reduction. Every function tests for it first, for speed.
template <typename T>
bool in_first_octant(T x) {
    return abs(x) <= kPi<T> / T{4};
}

// Below, sin x = tan x = x to within rounding, which also keeps the sign of a zero.
template <typename T>
inline constexpr T kTiny = std::numeric_limits<T>::digits == 24 ? T{0x1p-13} : T{0x1p-27};

// The kernels take r in [-pi/4, pi/4], or a little beyond. What is added to r or 1 last is small,
// so that little but the last rounding is left as error.
template <typename T>
T sin_kernel(DoubleWord<T> r) {
    if (abs(r.high) < kTiny<T>) return r.high;
    const T z = square(r.high);
    const T cubic = r.high * z * detail::polynomial(z, Coefficients<T>::kSin);
    return r.high + (cubic + r.low * (T{1} - T{0.5} * z));
}

template <typename T>
T cos_kernel(DoubleWord<T> r) {
    const T z = square(r.high);
    const T half = T{0.5} * z;
    const T leading = T{1} - half;
    const T rest = z * z * detail::polynomial(z, Coefficients<T>::kCos) - r.high * r.low;
    return leading + (((T{1} - leading) - half) + rest);
}

template <typename T>
T sin_of(T x) {
    if (in_first_octant(x)) return sin_kernel<T>({x, T{0}});
    if (!is_finite(x)) return canonical_nan<T>();
    const ReducedAngle<T> angle = detail::reduce_angle(x);
    const bool odd = (angle.quarter_turns & 1) != 0;
    const T value = odd ? cos_kernel(angle.rest) : sin_kernel(angle.rest);
    return (angle.quarter_turns & 2) != 0 ? -value : value;
}

template <typename T>
T cos_of(T x) {
    if (in_first_octant(x)) return cos_kernel<T>({x, T{0}});
    if (!is_finite(x)) return canonical_nan<T>();
    const ReducedAngle<T> angle = detail::reduce_angle(x);
    const bool odd = (angle.quarter_turns & 1) != 0;
    const T value = odd ? sin_kernel(angle.rest) : cos_kernel(angle.rest);
    return ((angle.quarter_turns + 1) & 2) != 0 ? -value : value;
}

template <typename T>
SinCos<T> sincos_of(T x) {
    if (in_first_octant(x)) return {sin_kernel<T>({x, T{0}}), cos_kernel<T>({x, T{0}})};
    if (!is_finite(x)) return {canonical_nan<T>(), canonical_nan<T>()};
    const ReducedAngle<T> angle = detail::reduce_angle(x);
    const T s = sin_kernel(angle.rest);
    const T c = cos_kernel(angle.rest);
    switch (angle.quarter_turns & 3) {
        case 0:
            return {s, c};
        case 1:
            return {c, -s};
        case 2:
            return {-s, -c};
        default:
            return {-c, s};
    }
}

// As the kernels above, with the last sum not yet rounded.
template <typename T>
DoubleWord<T> sin_double_word(DoubleWord<T> r) {
    const T z = square(r.high);
    const T cubic = r.high * z * detail::polynomial(z, Coefficients<T>::kSin);
    return detail::fast_two_sum(r.high, cubic + r.low * (T{1} - T{0.5} * z));
}

template <typename T>
DoubleWord<T> cos_double_word(DoubleWord<T> r) {
    const DoubleWord<T> square_of_high = detail::two_product(r.high, r.high);
    const T z = square_of_high.high;
    const T rest = z * z * detail::polynomial(z, Coefficients<T>::kCos) - r.high * r.low;
    const DoubleWord<T> leading = detail::fast_two_sum(T{1}, T{-0.5} * z);
    return detail::fast_two_sum(leading.high, leading.low + (rest - T{0.5} * square_of_high.low));
}

template <typename T>
T tan_of(T x) {
    if (!is_finite(x)) return canonical_nan<T>();
    if (abs(x) < kTiny<T>) return x;
    const ReducedAngle<T> angle =
        in_first_octant(x) ? ReducedAngle<T>{{x, T{0}}, 0} : detail::reduce_angle(x);
    const DoubleWord<T> s = sin_double_word(angle.rest);
    const DoubleWord<T> c = cos_double_word(angle.rest);
    if ((angle.quarter_turns & 1) == 0) return detail::divide(s, c).high;
    return -detail::divide(c, s).high;
}

template <typename T>
T wrapped(T x) {
    if (abs(x) <= kPi<T>) return x;
    if (!is_finite(x)) return canonical_nan<T>();
    return detail::reduce_turns(x).high;
}

}  // namespace

float sin(float x) {
    return sin_of(x);
}
double sin(double x) {
    return sin_of(x);
}
float cos(float x) {
    return cos_of(x);
}
double cos(double x) {
    return cos_of(x);
}
SinCos<float> sincos(float x) {
    return sincos_of(x);
}
SinCos<double> sincos(double x) {
    return sincos_of(x);
}
float tan(float x) {
    return tan_of(x);
}
double tan(double x) {
    return tan_of(x);
}
float wrap_pi(float x) {
    return wrapped(x);
}
double wrap_pi(double x) {
    return wrapped(x);
}

}  // namespace stator::math
