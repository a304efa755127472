// Any angle reduced by multiples of pi/2, with integers (after Payne and Hanek 1983).
#pragma once

#include "detail/double_word.hpp"

namespace stator::math::detail {

// x = rest + quarter_turns * pi/2 (mod 2 pi), |rest| at most a little over pi/4, quarter_turns in
// 0..3.
template <std::floating_point T>
struct ReducedAngle {
    DoubleWord<T> rest;
    unsigned quarter_turns;
};

// x finite, |x| > pi/4. The rest is good to 2^-30 (float) or 2^-60 (double) of itself.
ReducedAngle<float> reduce_angle(float x);
ReducedAngle<double> reduce_angle(double x);

// x modulo 2 pi, in [-pi, pi], as good as that.
DoubleWord<float> reduce_turns(float x);
DoubleWord<double> reduce_turns(double x);

}  // namespace stator::math::detail
