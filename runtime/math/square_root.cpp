// Square root by integers, for machines whose FPU lacks the instruction.
#include "stator/math/square_root.hpp"

#include "detail/exponent.hpp"

namespace stator::math::detail {

namespace {

template <typename T>
T sqrt_bit_by_bit(T x) {
    using Format = FloatFormat<T>;
    using Bits = typename Format::Bits;
    if (x == T{0} || is_nan(x)) return x;
    if (x < T{0}) return canonical_nan<T>();
    if (!is_finite(x)) return x;
    auto [rest, exponent] = decompose(x);
    const int odd = (exponent + Format::kFractionBits) & 1;
    rest <<= odd;
    // Now x = rest * 2^(exponent - odd), and `rest`, as a number with its point at kFractionBits,
    // lies in [1, 4). Its root, in [1, 2), grows by one bit a step, down to one beyond the last
    // place; `rest` stays below twice the root.
    Bits root = 0;
    for (Bits bit = Format::kFractionMask + 1; bit != 0; bit >>= 1) {
        const Bits trial = (root << 1) | bit;
        if (rest >= trial) {
            rest -= trial;
            root |= bit;
        }
        rest <<= 1;
    }
    // The root of such a number is never half-way between two others.
    if (rest > (root << 1)) ++root;
    const int root_exponent = (exponent - odd + Format::kFractionBits) / 2;
    const T mantissa = from_bits<T>(to_bits(T{1}) | (root & Format::kFractionMask));
    return mantissa * power_of_two<T>(root_exponent);
}

}  // namespace

float sqrt_by_integers(float x) {
    return sqrt_bit_by_bit(x);
}
double sqrt_by_integers(double x) {
    return sqrt_bit_by_bit(x);
}

}  // namespace stator::math::detail
