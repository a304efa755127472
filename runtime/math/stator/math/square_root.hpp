// Square root, correctly rounded: one instruction where the machine has it, integers elsewhere.
#pragma once

#include "stator/math/bits.hpp"

#if defined(__SSE2__)
#include <emmintrin.h>
#endif

namespace stator::math {

namespace detail {

// One result bit per step, no floating point. Same bits as the instruction, a NaN's sign aside.
float sqrt_by_integers(float x);
double sqrt_by_integers(double x);

}  // namespace detail

// sqrt(-0) is -0; a negative x gives a NaN. An intrinsic or assembly and never std::sqrt, because
// compilers turn that into a call of libm at -O0. __ARM_FP: bit 2 is single, bit 3 double.
inline float sqrt(float x) {
#if defined(__SSE2__)
    return _mm_cvtss_f32(_mm_sqrt_ss(_mm_set_ss(x)));
#elif defined(__aarch64__)
    float root;
    __asm__("fsqrt %s0, %s1" : "=w"(root) : "w"(x));
    return root;
#elif defined(__ARM_FP) && (__ARM_FP & 4)
    float root;
    __asm__("vsqrt.f32 %0, %1" : "=t"(root) : "t"(x));
    return root;
#else
    return detail::sqrt_by_integers(x);
#endif
}

inline double sqrt(double x) {
#if defined(__SSE2__)
    return _mm_cvtsd_f64(_mm_sqrt_pd(_mm_set_sd(x)));
#elif defined(__aarch64__)
    double root;
    __asm__("fsqrt %d0, %d1" : "=w"(root) : "w"(x));
    return root;
#elif defined(__ARM_FP) && (__ARM_FP & 8)
    double root;
    __asm__("vsqrt.f64 %P0, %P1" : "=w"(root) : "w"(x));
    return root;
#else
    return detail::sqrt_by_integers(x);
#endif
}

}  // namespace stator::math
