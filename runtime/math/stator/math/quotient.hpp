// A whole number over a whole number as a double, without an instruction for doubles: for
// positions, which arrive as integers, on chips that have single precision only.
#pragma once

#include <bit>
#include <cstdint>

namespace stator::math {

// Correctly rounded, halfway cases to even. `denominator` is not 0.
constexpr double quotient(int64_t numerator, uint32_t denominator) {
    const uint64_t sign = numerator < 0 ? uint64_t{1} << 63 : 0;
    const uint64_t magnitude = numerator < 0 ? uint64_t{0} - static_cast<uint64_t>(numerator)
                                             : static_cast<uint64_t>(numerator);
    if (magnitude == 0) return 0.0;
    // Long division, one bit at a time, until the quotient has a double's 53 bits and one more.
    uint64_t whole = magnitude / denominator;
    uint64_t rest = magnitude % denominator;
    int exponent = 1023 + 52;
    bool sticky = false;
    while (whole < (uint64_t{1} << 53)) {
        rest <<= 1;
        const bool bit = rest >= denominator;
        whole = (whole << 1) | (bit ? 1 : 0);
        if (bit) rest -= denominator;
        --exponent;
    }
    while (whole >= (uint64_t{1} << 54)) {
        sticky = sticky || (whole & 1) != 0;
        whole >>= 1;
        ++exponent;
    }
    sticky = sticky || rest != 0;
    const bool up = (whole & 1) != 0 && (sticky || (whole & 2) != 0);
    // The quotient's top bit adds 1 to the exponent; rounding may carry into it, which is right,
    // too.
    const uint64_t bits = (static_cast<uint64_t>(exponent) << 52) + (whole >> 1) + (up ? 1 : 0);
    return std::bit_cast<double>(sign | bits);
}

}  // namespace stator::math
