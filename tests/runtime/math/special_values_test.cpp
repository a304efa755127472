// What the functions say at the ends: zeros, infinities, NaN, domain errors, exact cases. Expected
// values are those of C17 Annex F, except where a comment says otherwise.
#include <gtest/gtest.h>

#include "stator/scalar.hpp"

namespace stator::math {
namespace {

template <typename T>
class Special : public ::testing::Test {
  protected:
    static constexpr T kInfinity = std::numeric_limits<T>::infinity();
    static constexpr T kLeast = std::numeric_limits<T>::denorm_min();
    static constexpr T kLargest = std::numeric_limits<T>::max();

    // Same bits, so that the sign of a zero counts.
    static void expect_same(T value, T expected) {
        EXPECT_EQ(to_bits(value), to_bits(expected)) << std::hexfloat << value << " " << expected;
    }
    static void expect_nan(T value) { expect_same(value, canonical_nan<T>()); }
};

using Types = ::testing::Types<float, double>;
TYPED_TEST_SUITE(Special, Types, );

TYPED_TEST(Special, BitTests) {
    using T = TypeParam;
    EXPECT_TRUE(is_nan(std::numeric_limits<T>::quiet_NaN()));
    EXPECT_TRUE(is_nan(-std::numeric_limits<T>::signaling_NaN()));
    EXPECT_FALSE(is_nan(this->kInfinity));
    EXPECT_FALSE(is_nan(this->kLargest));
    EXPECT_TRUE(is_finite(-this->kLargest));
    EXPECT_TRUE(is_finite(this->kLeast));
    EXPECT_FALSE(is_finite(-this->kInfinity));
    EXPECT_FALSE(is_finite(canonical_nan<T>()));
    this->expect_nan(canonical(-std::numeric_limits<T>::quiet_NaN()));
    this->expect_same(canonical(-T{0}), -T{0});
    this->expect_same(canonical(-this->kInfinity), -this->kInfinity);
}

TEST(SpecialBits, CanonicalNanIsThePositiveQuietOneWithoutPayload) {
    EXPECT_EQ(to_bits(canonical_nan<float>()), 0x7fc00000u);
    EXPECT_EQ(to_bits(canonical_nan<double>()), 0x7ff8000000000000u);
}

TYPED_TEST(Special, SignAndOrder) {
    using T = TypeParam;
    this->expect_same(abs(-T{0}), T{0});
    this->expect_same(abs(-this->kInfinity), this->kInfinity);
    this->expect_same(copysign(T{2}, -T{0}), T{-2});
    this->expect_same(copysign(T{-2}, T{1}), T{2});
    this->expect_same(sign(T{-3}), T{-1});
    this->expect_same(sign(this->kLeast), T{1});
    this->expect_same(sign(-T{0}), T{0});
    this->expect_same(sign(canonical_nan<T>()), T{0});
    this->expect_same(square(T{-3}), T{9});
    this->expect_same(min(T{1}, T{2}), T{1});
    this->expect_same(max(T{1}, T{2}), T{2});
    this->expect_same(min(-T{0}, T{0}), -T{0});
    this->expect_same(max(-T{0}, T{0}), -T{0});
    this->expect_same(min(T{1}, canonical_nan<T>()), T{1});
    this->expect_same(clamp(T{5}, T{-1}, T{2}), T{2});
    this->expect_same(clamp(-this->kInfinity, T{-1}, T{2}), T{-1});
    this->expect_same(clamp(T{0.5}, T{-1}, T{2}), T{0.5});
    EXPECT_TRUE(is_nan(clamp(canonical_nan<T>(), T{-1}, T{2})));
}

TYPED_TEST(Special, Rounding) {
    using T = TypeParam;
    struct Row {
        T x, floor, ceil, trunc, round;
    };
    const T below_half = T{0.5} - std::numeric_limits<T>::epsilon() / T{4};
    const T whole = T{1} / std::numeric_limits<T>::epsilon();  // from here on, no fractions
    const Row rows[] = {
        {T{0}, T{0}, T{0}, T{0}, T{0}},
        {-T{0}, -T{0}, -T{0}, -T{0}, -T{0}},
        {T{0.25}, T{0}, T{1}, T{0}, T{0}},
        {T{-0.25}, T{-1}, -T{0}, -T{0}, -T{0}},
        {T{0.5}, T{0}, T{1}, T{0}, T{1}},
        {T{-0.5}, T{-1}, -T{0}, -T{0}, T{-1}},
        {below_half, T{0}, T{1}, T{0}, T{0}},
        {T{2.5}, T{2}, T{3}, T{2}, T{3}},
        {T{-2.5}, T{-3}, T{-2}, T{-2}, T{-3}},
        {T{-7}, T{-7}, T{-7}, T{-7}, T{-7}},
        {whole - T{0.5}, whole - T{1}, whole, whole - T{1}, whole},
        {whole + T{1}, whole + T{1}, whole + T{1}, whole + T{1}, whole + T{1}},
        {-this->kLargest, -this->kLargest, -this->kLargest, -this->kLargest, -this->kLargest},
        {this->kInfinity, this->kInfinity, this->kInfinity, this->kInfinity, this->kInfinity},
        {this->kLeast, T{0}, T{1}, T{0}, T{0}},
    };
    for (const Row& row : rows) {
        SCOPED_TRACE(row.x);
        this->expect_same(floor(row.x), row.floor);
        this->expect_same(ceil(row.x), row.ceil);
        this->expect_same(trunc(row.x), row.trunc);
        this->expect_same(round(row.x), row.round);
    }
    EXPECT_TRUE(is_nan(floor(canonical_nan<T>())));
    EXPECT_TRUE(is_nan(round(canonical_nan<T>())));
}

TYPED_TEST(Special, Saturate) {
    using T = TypeParam;
    EXPECT_EQ(saturate<std::int32_t>(T(-2.9)), -2);
    EXPECT_EQ(saturate<std::int32_t>(T(1e30)), 2147483647);
    EXPECT_EQ(saturate<std::int32_t>(T(0x1p31)), 2147483647);
    EXPECT_EQ(saturate<std::int32_t>(T(-0x1p31)), -2147483647 - 1);
    EXPECT_EQ(saturate<std::int32_t>(-this->kInfinity), -2147483647 - 1);
    EXPECT_EQ(saturate<std::int32_t>(canonical_nan<T>()), 0);
    EXPECT_EQ(saturate<std::int32_t>(-canonical_nan<T>()), 0);
    EXPECT_EQ(saturate<std::uint32_t>(T{-0.5}), 0u);
    EXPECT_EQ(saturate<std::uint32_t>(T{-7}), 0u);
    EXPECT_EQ(saturate<std::uint32_t>(T(0x1p32)), 0xffffffffu);
    EXPECT_EQ(saturate<std::uint32_t>(T(0x1.fffffep31)), 0xffffff00u);
    EXPECT_EQ(saturate<std::int8_t>(T(127.9)), 127);
    EXPECT_EQ(saturate<std::int8_t>(T{128}), 127);
    EXPECT_EQ(saturate<std::int8_t>(T(-128.9)), -128);
    EXPECT_EQ(saturate<std::uint8_t>(T(255.9)), 255);
    EXPECT_EQ(saturate<std::uint16_t>(T{70000}), 65535);
    EXPECT_EQ(saturate<std::int64_t>(T(0x1p63)), std::numeric_limits<std::int64_t>::max());
    EXPECT_EQ(saturate<std::int64_t>(T(0x1p62)), std::int64_t{1} << 62);
    EXPECT_EQ(saturate<std::int64_t>(T(-0x1p63)), std::numeric_limits<std::int64_t>::min());
    EXPECT_EQ(saturate<std::uint64_t>(T(0x1p63)), std::uint64_t{1} << 63);
    EXPECT_EQ(saturate<std::uint64_t>(T(0x1p64)), std::numeric_limits<std::uint64_t>::max());
}

TYPED_TEST(Special, SquareRoot) {
    using T = TypeParam;
    for (T (*root)(T) :
         {static_cast<T (*)(T)>(sqrt), static_cast<T (*)(T)>(detail::sqrt_by_integers)}) {
        this->expect_same(root(T{0}), T{0});
        this->expect_same(root(-T{0}), -T{0});
        this->expect_same(root(T{6.25}), T{2.5});
        this->expect_same(root(this->kInfinity), this->kInfinity);
        // The sign of this NaN is the machine's.
        this->expect_nan(canonical(root(T{-1})));
        this->expect_nan(canonical(root(canonical_nan<T>())));
    }
}

TYPED_TEST(Special, Trigonometry) {
    using T = TypeParam;
    for (T (*function)(T) : {static_cast<T (*)(T)>(sin), static_cast<T (*)(T)>(tan)}) {
        this->expect_same(function(T{0}), T{0});
        this->expect_same(function(-T{0}), -T{0});
        this->expect_same(function(-this->kLeast), -this->kLeast);
        this->expect_nan(function(this->kInfinity));
        this->expect_nan(function(canonical_nan<T>()));
    }
    this->expect_same(cos(-T{0}), T{1});
    this->expect_same(cos(this->kLeast), T{1});
    this->expect_nan(cos(-this->kInfinity));
    this->expect_nan(sincos(-this->kInfinity).sin);
    this->expect_nan(sincos(canonical_nan<T>()).cos);
}

TYPED_TEST(Special, WrapPi) {
    using T = TypeParam;
    this->expect_same(wrap_pi(-T{0}), -T{0});
    this->expect_same(wrap_pi(kPi<T>), kPi<T>);
    this->expect_same(wrap_pi(-kPi<T>), -kPi<T>);
    this->expect_same(wrap_pi(T{1}), T{1});
    EXPECT_NEAR(static_cast<double>(wrap_pi(T{4})), 4.0 - 2.0 * kPi<double>, 1e-7);
    EXPECT_NEAR(static_cast<double>(wrap_pi(T{-4})), 2.0 * kPi<double> - 4.0, 1e-7);
    EXPECT_LE(abs(wrap_pi(this->kLargest)), kPi<T>);
    this->expect_nan(wrap_pi(this->kInfinity));
    this->expect_nan(wrap_pi(canonical_nan<T>()));
}

TYPED_TEST(Special, InverseTrigonometry) {
    using T = TypeParam;
    this->expect_same(atan(-T{0}), -T{0});
    this->expect_same(atan(this->kInfinity), kHalfPi<T>);
    this->expect_same(atan(-this->kLargest), -kHalfPi<T>);
    this->expect_same(atan(this->kLeast), this->kLeast);
    this->expect_same(asin(-T{0}), -T{0});
    this->expect_same(asin(T{1}), kHalfPi<T>);
    this->expect_same(asin(T{-1}), -kHalfPi<T>);
    this->expect_same(asin(this->kLeast), this->kLeast);
    this->expect_same(acos(T{1}), T{0});
    this->expect_same(acos(T{-1}), kPi<T>);
    this->expect_same(acos(T{0}), kHalfPi<T>);
    const T beyond = T{1} + std::numeric_limits<T>::epsilon();
    for (const T x : {beyond, -beyond, this->kInfinity, canonical_nan<T>()}) {
        this->expect_nan(asin(x));
        this->expect_nan(acos(x));
    }
    this->expect_nan(atan(canonical_nan<T>()));
}

TYPED_TEST(Special, Atan2) {
    using T = TypeParam;
    const T infinity = this->kInfinity;
    this->expect_same(atan2(T{0}, T{0}), T{0});
    this->expect_same(atan2(-T{0}, T{0}), -T{0});
    this->expect_same(atan2(T{0}, -T{0}), kPi<T>);
    this->expect_same(atan2(-T{0}, -T{0}), -kPi<T>);
    this->expect_same(atan2(-T{0}, T{-2}), -kPi<T>);
    this->expect_same(atan2(-T{0}, T{2}), -T{0});
    this->expect_same(atan2(T{3}, -T{0}), kHalfPi<T>);
    this->expect_same(atan2(T{-3}, T{0}), -kHalfPi<T>);
    this->expect_same(atan2(infinity, T{1}), kHalfPi<T>);
    this->expect_same(atan2(T{1}, -infinity), kPi<T>);
    this->expect_same(atan2(T{-1}, infinity), -T{0});
    this->expect_same(atan2(infinity, infinity), kPi<T> / T{4});
    this->expect_same(atan2(-infinity, -infinity), T(-3) * kPi<T> / T{4});
    this->expect_same(atan2(this->kLeast, this->kLargest), T{0});
    this->expect_same(atan2(this->kLargest, this->kLargest), kPi<T> / T{4});
    this->expect_same(atan2(this->kLeast, this->kLeast), kPi<T> / T{4});
    this->expect_nan(atan2(canonical_nan<T>(), T{1}));
    this->expect_nan(atan2(infinity, canonical_nan<T>()));
}

TYPED_TEST(Special, ExpAndLog) {
    using T = TypeParam;
    this->expect_same(exp(-T{0}), T{1});
    this->expect_same(exp(this->kLeast), T{1});
    this->expect_same(exp(this->kInfinity), this->kInfinity);
    this->expect_same(exp(this->kLargest), this->kInfinity);
    this->expect_same(exp(-this->kInfinity), T{0});
    this->expect_same(exp(-this->kLargest), T{0});
    this->expect_nan(exp(canonical_nan<T>()));
    this->expect_same(log(T{1}), T{0});
    this->expect_same(log(-T{0}), -this->kInfinity);
    this->expect_same(log(this->kInfinity), this->kInfinity);
    this->expect_nan(log(-this->kLeast));
    this->expect_nan(log(canonical_nan<T>()));
}

TYPED_TEST(Special, PowOfZerosAndInfinities) {
    using T = TypeParam;
    const T infinity = this->kInfinity;
    this->expect_same(pow(T{0}, T{3}), T{0});
    this->expect_same(pow(-T{0}, T{3}), -T{0});
    this->expect_same(pow(-T{0}, T{2}), T{0});
    this->expect_same(pow(-T{0}, T{-3}), -infinity);
    this->expect_same(pow(-T{0}, T{-2.5}), infinity);
    this->expect_same(pow(-T{0}, -infinity), infinity);
    this->expect_same(pow(infinity, T{0.5}), infinity);
    this->expect_same(pow(infinity, T{-1}), T{0});
    this->expect_same(pow(-infinity, T{3}), -infinity);
    this->expect_same(pow(-infinity, T{-3}), -T{0});
    this->expect_same(pow(-infinity, T{-2}), T{0});
    this->expect_same(pow(-infinity, T{0.5}), infinity);
    this->expect_same(pow(T{0.5}, infinity), T{0});
    this->expect_same(pow(T{0.5}, -infinity), infinity);
    this->expect_same(pow(T{-2}, infinity), infinity);
    this->expect_same(pow(T{-2}, -infinity), T{0});
    this->expect_same(pow(T{-1}, infinity), T{1});
}

TYPED_TEST(Special, Pow) {
    using T = TypeParam;
    this->expect_same(pow(canonical_nan<T>(), T{0}), T{1});
    this->expect_same(pow(T{1}, canonical_nan<T>()), T{1});
    this->expect_nan(pow(canonical_nan<T>(), T{1}));
    this->expect_nan(pow(T{2}, canonical_nan<T>()));
    this->expect_nan(pow(T{-2}, T{0.5}));
    this->expect_same(pow(T{-2}, T{3}), T{-8});
    this->expect_same(pow(T{-2}, T{4}), T{16});
    this->expect_same(pow(T{-1}, this->kLargest), T{1});
    this->expect_same(pow(T{-1}, T{1} / std::numeric_limits<T>::epsilon() + T{1}), T{-1});
    this->expect_same(pow(T{3}, T{5}), T{243});
    this->expect_same(pow(T{10}, T{-1}), T{1} / T{10});
    this->expect_same(pow(T{2}, this->kLargest), this->kInfinity);
    this->expect_same(pow(T{2}, -this->kLargest), T{0});
    this->expect_same(pow(T{-2}, T{2001}), -this->kInfinity);
    this->expect_same(pow(T{2}, this->kLeast), T{1});
    this->expect_same(
        pow(T{2}, T(std::numeric_limits<T>::min_exponent - std::numeric_limits<T>::digits)),
        this->kLeast);
}

}  // namespace
}  // namespace stator::math
