// Exponential, natural logarithm, power.
#include "detail/coefficients.hpp"
#include "detail/exponent.hpp"
#include "detail/polynomial.hpp"
#include "stator/scalar.hpp"

namespace stator::math {

namespace {

using detail::Coefficients;
using detail::DoubleWord;

// x * 2^n for x in about [1/2, 2] and any n that leads to a number, rounded once: the first step is
// exact.
template <typename T>
T times_power_of_two(T x, int n) {
    constexpr int kLimit = FloatFormat<T>::kExponentBias - 1;
    if (n > kLimit)
        return x * detail::power_of_two<T>(kLimit) * detail::power_of_two<T>(n - kLimit);
    if (n >= -kLimit) return x * detail::power_of_two<T>(n);
    return x * detail::power_of_two<T>(n / 2) * detail::power_of_two<T>(n - n / 2);
}

// exp(x.high + x.low). exp x = 2^n exp r, |r| <= log(2)/2.
template <typename T>
T exp_of(DoubleWord<T> x) {
    using C = Coefficients<T>;
    using Limits = std::numeric_limits<T>;
    // Beyond these, whole or half of the least number apart, the result is infinite or 0.
    constexpr T kHighest = static_cast<T>(Limits::max_exponent) * C::kLn2.high + T{0.0625};
    constexpr T kLowest = static_cast<T>(Limits::min_exponent - Limits::digits - 1) * C::kLn2.high;
    if (x.high > kHighest) return Limits::infinity();
    if (x.high < kLowest) return T{0};
    const T n = detail::nearest(x.high * C::kLog2E);
    const T leading = x.high - n * C::kLn2.high;
    const DoubleWord<T> part = detail::two_sum(leading, -n * C::kLn2.low);
    const DoubleWord<T> r = detail::two_sum(part.high, part.low + x.low);
    const T rest = square(r.high) * detail::polynomial(r.high, C::kExp);
    const DoubleWord<T> sum = detail::fast_two_sum(T{1}, r.high);
    const T value = sum.high + (sum.low + (rest + (r.low + r.high * r.low)));
    return times_power_of_two(value, saturate<int>(n));
}

// x = 2^exponent * (1 + fraction), 1 + fraction in [sqrt(1/2), sqrt(2)).
template <typename T>
struct LogParts {
    T exponent;
    T fraction;
};

template <typename T>
LogParts<T> log_parts(T x) {
    using Format = FloatFormat<T>;
    const auto [integer, exponent] = detail::decompose(x);
    constexpr auto kSqrt2 = static_cast<T>(1.4142135623730951);
    const T mantissa = from_bits<T>(to_bits(T{1}) | (integer & Format::kFractionMask));
    const int n = exponent + Format::kFractionBits;
    if (mantissa > kSqrt2) return {static_cast<T>(n + 1), T{0.5} * mantissa - T{1}};
    return {static_cast<T>(n), mantissa - T{1}};
}

// With s = f / (2 + f): log(1 + f) = 2 s + s R = f - f^2/2 + s (f^2/2 + R), R = s^2 P(s^2).
template <typename T>
T log_of(T x) {
    using C = Coefficients<T>;
    if (is_nan(x) || x < T{0}) return canonical_nan<T>();
    if (x == T{0}) return -std::numeric_limits<T>::infinity();
    if (!is_finite(x)) return x;
    const auto [n, f] = log_parts(x);
    const T s = f / (T{2} + f);
    const T z = square(s);
    const T half_square = T{0.5} * square(f);
    const T small = s * (half_square + z * detail::polynomial(z, C::kLog)) + n * C::kLn2.low;
    const DoubleWord<T> leading =
        n == T{0} ? DoubleWord<T>{f, T{0}} : detail::fast_two_sum(n * C::kLn2.high, f);
    return leading.high + (leading.low + (small - half_square));
}

// log x to about twice the precision; x > 0 and finite. The first two terms of P in s^2 are double
// words, the others count too little to be.
template <typename T>
DoubleWord<T> log_double_word(T x) {
    using C = Coefficients<T>;
    const auto [n, f] = log_parts(x);
    if (f == T{0} && n == T{0}) return {T{0}, T{0}};
    const DoubleWord<T> s = detail::divide(DoubleWord<T>{f, T{0}}, detail::two_sum(T{2}, f));
    const DoubleWord<T> z = detail::multiply(s, s);
    const T rest = z.high * detail::polynomial(z.high, C::kLogRest);
    DoubleWord<T> series = detail::add(C::kTwoFifths, DoubleWord<T>{rest, T{0}});
    series = detail::add(C::kTwoThirds, detail::multiply(z, series));
    series = detail::multiply(detail::multiply(s, z), series);
    const DoubleWord<T> log_mantissa =
        detail::add(DoubleWord<T>{T{2} * s.high, T{2} * s.low}, series);
    const DoubleWord<T> product = detail::two_product(n, C::kLn2.low);
    const DoubleWord<T> log_power = detail::two_sum(n * C::kLn2.high, product.high);
    return detail::add(DoubleWord<T>{log_power.high, log_power.low + product.low}, log_mantissa);
}

enum class Parity { kNoInteger, kEven, kOdd };

template <typename T>
Parity parity(T y) {
    if (trunc(y) != y) return Parity::kNoInteger;
    // From 2^24 or 2^53 on, every number is even; infinity counts as such, too.
    if (abs(y) >= T{2} / std::numeric_limits<T>::epsilon()) return Parity::kEven;
    return T{2} * trunc(T{0.5} * y) == y ? Parity::kEven : Parity::kOdd;
}

// x^y for x > 0, x not 1, both finite.
template <typename T>
T positive_power(T x, T y) {
    // Beyond any result's logarithm, and beyond what products can hold.
    constexpr T kHuge = std::numeric_limits<T>::digits == 24 ? T{0x1p40} : T{0x1p80};
    const T bounded = clamp(y, -kHuge, kHuge);
    return exp_of(detail::multiply(log_double_word(x), DoubleWord<T>{bounded, T{0}}));
}

template <typename T>
T pow_of(T x, T y) {
    if (y == T{0} || x == T{1}) return T{1};
    if (is_nan(x) || is_nan(y)) return canonical_nan<T>();
    const T magnitude = abs(x);
    if (!is_finite(y)) {
        if (magnitude == T{1}) return T{1};
        return (magnitude > T{1}) == (y > T{0}) ? abs(y) : T{0};
    }
    const Parity of_y = parity(y);
    const T sign_of_result = of_y == Parity::kOdd ? copysign(T{1}, x) : T{1};
    if (magnitude == T{0} || !is_finite(magnitude)) {
        const bool large = (magnitude == T{0}) == (y < T{0});
        return copysign(large ? std::numeric_limits<T>::infinity() : T{0}, sign_of_result);
    }
    if (x < T{0} && of_y == Parity::kNoInteger) return canonical_nan<T>();
    if (magnitude == T{1}) return sign_of_result;
    return sign_of_result * positive_power(magnitude, y);
}

template <typename T>
T exp_total(T x) {
    return is_nan(x) ? canonical_nan<T>() : exp_of(DoubleWord<T>{x, T{0}});
}

}  // namespace

float exp(float x) {
    return exp_total(x);
}
double exp(double x) {
    return exp_total(x);
}
float log(float x) {
    return log_of(x);
}
double log(double x) {
    return log_of(x);
}
float pow(float x, float y) {
    return pow_of(x, y);
}
double pow(double x, double y) {
    return pow_of(x, y);
}

}  // namespace stator::math
