// Evaluation of a polynomial whose coefficients are known when compiling.
#pragma once

#include <cstddef>

namespace stator::math::detail {

// Horner's rule, lowest power first in the table. A template per step, so that it is unrolled.
template <std::size_t from = 0, typename T, std::size_t count>
constexpr T polynomial(T x, const T (&coefficients)[count]) {
    if constexpr (from + 1 == count) {
        return coefficients[from];
    } else {
        return coefficients[from] + x * polynomial<from + 1>(x, coefficients);
    }
}

}  // namespace stator::math::detail
