// Reduction of angles in fixed point: x * 2/pi modulo 4, of which only those bits of 2/pi are used
// that neither make whole turns nor lie below the precision needed.
#include "detail/reduction.hpp"

#include "detail/exponent.hpp"

namespace stator::math::detail {

namespace {

// 32 or 64 bits of the table from a bit on.
std::uint32_t bits_32(unsigned position) {
    const std::uint32_t* word = &kTwoOverPi[position / 32];
    const std::uint64_t both = (static_cast<std::uint64_t>(word[0]) << 32) | word[1];
    return static_cast<std::uint32_t>((both << (position % 32)) >> 32);
}

std::uint64_t bits_64(unsigned position) {
    return (static_cast<std::uint64_t>(bits_32(position)) << 32) | bits_32(position + 32);
}

// 128 bits, since no type has them everywhere.
struct Wide {
    std::uint64_t high;
    std::uint64_t low;
};

Wide multiply(std::uint64_t a, std::uint64_t b) {
    constexpr std::uint64_t kLow = 0xffffffff;
    const std::uint64_t low = (a & kLow) * (b & kLow);
    const std::uint64_t middle_a = (a >> 32) * (b & kLow) + (low >> 32);
    const std::uint64_t middle_b = (a & kLow) * (b >> 32) + (middle_a & kLow);
    const std::uint64_t high = (a >> 32) * (b >> 32) + (middle_a >> 32) + (middle_b >> 32);
    return {high, (middle_b << 32) | (low & kLow)};
}

// The table's bit 64 + i has weight 2^-(i+1). For x = integer * 2^exponent, bits whose product with
// x is a multiple of 4 are left out: the first one kept makes 2 * integer.
unsigned first_bit(int exponent) {
    return static_cast<unsigned>(62 + exponent);
}

// |x| * 2/pi modulo 4 in units of 2^-62. 24 bits times 96 of 2/pi leave 70 good ones in the
// fraction; no float comes nearer to a multiple of pi/2 than about 2^-30 of one.
std::uint64_t quarter_turns(float x) {
    const auto [integer, exponent] = decompose(x);
    const unsigned first = first_bit(exponent);
    const std::uint64_t wide = integer;
    const std::uint64_t top = (wide * bits_32(first)) << 32;
    return top + wide * bits_32(first + 32) + ((wide * bits_32(first + 64)) >> 32);
}

// The same in units of 2^-126. 53 bits times 192 leave 137; no double comes nearer than 2^-62.
Wide quarter_turns(double x) {
    const auto [integer, exponent] = decompose(x);
    const unsigned first = first_bit(exponent);
    const Wide middle = multiply(integer, bits_64(first + 64));
    const std::uint64_t low = middle.low + multiply(integer, bits_64(first + 128)).high;
    const std::uint64_t carry = low < middle.low ? 1 : 0;
    return {integer * bits_64(first) + middle.high + carry, low};
}

Wide negated(Wide x) {
    return {~x.high + (x.low == 0 ? 1 : 0), ~x.low + 1};
}

Wide shifted_left(Wide x, int count) {
    if (count == 0) return x;
    if (count >= 64) return {x.low << (count & 63), 0};
    return {(x.high << count) | (x.low >> (64 - count)), x.low << count};
}

// A magnitude in units of 2^-64 or 2^-128 quarter turns, times pi/2. The 8 or 11 bits that do not
// fit into the first number make the second.
DoubleWord<float> radians(std::uint64_t magnitude) {
    constexpr std::uint64_t kHalfPiBits = 0xc90fdaa2;  // pi/2 in units of 2^-31
    if (magnitude == 0) return {0.0F, 0.0F};
    const int shift = std::countl_zero(magnitude);
    const auto product =
        static_cast<std::uint32_t>((((magnitude << shift) >> 32) * kHalfPiBits) >> 32);
    const float unit = power_of_two<float>(-31 - shift);
    const auto high = static_cast<std::int32_t>(product >> 8);
    const auto low = static_cast<std::int32_t>(product & 0xff);
    return fast_two_sum(static_cast<float>(high) * 256.0F * unit, static_cast<float>(low) * unit);
}

DoubleWord<double> radians(Wide magnitude) {
    constexpr std::uint64_t kHalfPiBits = 0xc90fdaa22168c235;  // pi/2 in units of 2^-63
    if ((magnitude.high | magnitude.low) == 0) return {0.0, 0.0};
    const int shift = magnitude.high != 0 ? std::countl_zero(magnitude.high)
                                          : 64 + std::countl_zero(magnitude.low);
    const std::uint64_t product = multiply(shifted_left(magnitude, shift).high, kHalfPiBits).high;
    const double unit = power_of_two<double>(-63 - shift);
    const auto high = static_cast<std::int64_t>(product >> 11);
    const auto low = static_cast<std::int64_t>(product & 0x7ff);
    return fast_two_sum(static_cast<double>(high) * 2048.0 * unit, static_cast<double>(low) * unit);
}

template <typename T>
DoubleWord<T> with_sign(DoubleWord<T> x, bool negative) {
    return negative ? DoubleWord<T>{-x.high, -x.low} : x;
}

// A negative angle takes as many quarter turns back.
template <typename T>
ReducedAngle<T> reduced(DoubleWord<T> magnitude, bool below, unsigned quarters, bool negative) {
    const DoubleWord<T> rest = with_sign(magnitude, below != negative);
    return {rest, (negative ? 4u - quarters : quarters) & 3u};
}

}  // namespace

ReducedAngle<float> reduce_any_angle(float x) {
    const std::uint64_t turns = quarter_turns(x);
    // Above half a quarter, `fraction` as a signed number is what is missing to the next one.
    const std::uint64_t fraction = turns << 2;
    const bool below = (fraction >> 63) != 0;
    const auto quarters = static_cast<unsigned>(turns >> 62) + (below ? 1u : 0u);
    return reduced(radians(below ? 0 - fraction : fraction), below, quarters, x < 0.0F);
}

ReducedAngle<double> reduce_any_angle(double x) {
    const Wide turns = quarter_turns(x);
    const Wide fraction = shifted_left(turns, 2);
    const bool below = (fraction.high >> 63) != 0;
    const auto quarters = static_cast<unsigned>(turns.high >> 62) + (below ? 1u : 0u);
    return reduced(radians(below ? negated(fraction) : fraction), below, quarters, x < 0.0);
}

DoubleWord<float> reduce_turns(float x) {
    const std::uint64_t turns = quarter_turns(x);
    const bool below = (turns >> 63) != 0;
    const DoubleWord<float> angle = radians(below ? 0 - turns : turns);
    return with_sign<float>({4.0F * angle.high, 4.0F * angle.low}, below != (x < 0.0F));
}

DoubleWord<double> reduce_turns(double x) {
    const Wide turns = quarter_turns(x);
    const bool below = (turns.high >> 63) != 0;
    const DoubleWord<double> angle = radians(below ? negated(turns) : turns);
    return with_sign<double>({4.0 * angle.high, 4.0 * angle.low}, below != (x < 0.0));
}

}  // namespace stator::math::detail
