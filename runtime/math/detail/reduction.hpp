// Angles reduced by multiples of pi/2: some hundred turns by subtraction (Cody and Waite 1980), any
// others with integers (Payne and Hanek 1983).
#pragma once

#include "detail/coefficients.hpp"
#include "detail/exponent.hpp"

namespace stator::math::detail {

// x = rest + quarter_turns * pi/2 (mod 2 pi), |rest| at most a little over pi/4; of quarter_turns
// only the last two bits count.
template <std::floating_point T>
struct ReducedAngle {
    DoubleWord<T> rest;
    unsigned quarter_turns;
};

// x finite, |x| > pi/4. The rest is good to 2^-30 (float) or 2^-60 (double) of itself.
ReducedAngle<float> reduce_any_angle(float x);
ReducedAngle<double> reduce_any_angle(double x);

// x modulo 2 pi, in [-pi, pi], as good as that.
DoubleWord<float> reduce_turns(float x);
DoubleWord<double> reduce_turns(double x);

// For subtraction: largest angle, so that quarter turns have 9 or 20 bits, and the rest below which
// cancellation leaves too few digits.
template <std::floating_point T>
inline constexpr T kMaxBySubtraction = std::numeric_limits<T>::digits == 24 ? T{800} : T{1000000};
template <std::floating_point T>
inline constexpr T kMinRest = std::numeric_limits<T>::digits == 24 ? T{0x1p-10} : T{0x1p-20};

// x finite. pi/2 comes in three parts, of which the first two times n are exact.
template <std::floating_point T>
inline ReducedAngle<T> reduce_angle(T x) {
    using C = Coefficients<T>;
    if (!(abs(x) < kMaxBySubtraction<T>)) return reduce_any_angle(x);
    const T n = nearest(x * C::kTwoOverPiRounded);
    const T first = x - n * C::kHalfPiParts[0];
    const DoubleWord<T> second = two_sum(first, -n * C::kHalfPiParts[1]);
    if (abs(second.high) < kMinRest<T>) return reduce_any_angle(x);
    const DoubleWord<T> rest = fast_two_sum(second.high, second.low - n * C::kHalfPiParts[2]);
    return {rest, static_cast<unsigned>(static_cast<int>(n))};
}

}  // namespace stator::math::detail
