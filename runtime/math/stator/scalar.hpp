// Stator's own maths on float and double: the same bits with every compiler, at every level of
// optimisation, on every machine, because nothing is used but + - * / sqrt and integers.
//
// Float functions hold no double, for machines whose FPU is single precision. Every function is
// total, reentrant, bounded in time and free of state; README.md states each one's largest error.
// A NaN in gives a NaN out. Where a bound is missing below, all finite arguments are good.
#pragma once

#include "stator/math/bits.hpp"
#include "stator/math/rounding.hpp"
#include "stator/math/square_root.hpp"

namespace stator::math {

template <std::floating_point T>
struct SinCos {
    T sin;
    T cos;
};

// Angles in radians. The reduction by pi/2 is exact enough for every finite argument, however
// large; an infinite one gives a NaN.
float sin(float x);
double sin(double x);
float cos(float x);
double cos(double x);
SinCos<float> sincos(float x);
SinCos<double> sincos(double x);
float tan(float x);
double tan(double x);

// The same angle in [-kPi, kPi]; an argument that lies there already is returned as it is.
float wrap_pi(float x);
double wrap_pi(double x);

// Signed zeros and infinities as in C's Annex F. asin and acos give a NaN beyond [-1, 1].
float atan(float x);
double atan(double x);
float atan2(float y, float x);
double atan2(double y, double x);
float asin(float x);
double asin(double x);
float acos(float x);
double acos(double x);

// log(0) is -infinity, log of a negative number a NaN. pow has the special cases of C's Annex F.
float exp(float x);
double exp(double x);
float log(float x);
double log(double x);
float pow(float x, float y);
double pow(double x, double y);

// Exact. fmod has the sign of x and a magnitude below |y|; remainder is IEEE 754's: x - n*y with
// n the whole number nearest to x/y, the even one of two. One step per bit by which the exponents
// differ: at most 277 for float, 2098 for double.
float fmod(float x, float y);
double fmod(double x, double y);
float remainder(float x, float y);
double remainder(double x, double y);

}  // namespace stator::math
