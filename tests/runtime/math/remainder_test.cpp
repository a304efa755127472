// fmod and remainder are exact, so the C library's, exact too, are the truth.
#include <gtest/gtest.h>

#include <cmath>

#include "stator/random.hpp"
#include "stator/scalar.hpp"

namespace stator::math {
namespace {

template <typename T>
T any(Random& random) {
    const std::uint64_t high = random.word();
    const std::uint64_t both = (high << 32) | random.word();
    return from_bits<T>(static_cast<typename FloatFormat<T>::Bits>(both));
}

template <typename T>
void expect_exact(T x, T y) {
    EXPECT_EQ(to_bits(fmod(x, y)), to_bits(canonical(std::fmod(x, y))))
        << std::hexfloat << x << " " << y;
    EXPECT_EQ(to_bits(remainder(x, y)), to_bits(canonical(std::remainder(x, y))))
        << std::hexfloat << x << " " << y;
}

template <typename T>
class Remainder : public ::testing::Test {};
using Types = ::testing::Types<float, double>;
TYPED_TEST_SUITE(Remainder, Types, );

TYPED_TEST(Remainder, OfAnyNumbers) {
    Random random(3);
    for (int i = 0; i < 20000; ++i) {
        const TypeParam x = any<TypeParam>(random);
        const TypeParam y = any<TypeParam>(random);
        if (is_nan(x) || is_nan(y)) continue;
        expect_exact(x, y);
    }
}

// Quotients up to 1000, many of them halves, where remainder rounds to even.
TYPED_TEST(Remainder, OfNearNumbers) {
    Random random(4);
    for (int i = 0; i < 20000; ++i) {
        const TypeParam y = static_cast<TypeParam>(random.word() % 100 + 1) / TypeParam{4};
        const TypeParam x = static_cast<TypeParam>(random.word() % 100000) / TypeParam{8};
        expect_exact(x, y);
        expect_exact(-x, y);
        expect_exact(x, -y);
    }
}

TYPED_TEST(Remainder, AtTheEnds) {
    using Limits = std::numeric_limits<TypeParam>;
    const TypeParam values[] = {TypeParam{0},
                                -TypeParam{0},
                                Limits::denorm_min(),
                                Limits::min(),
                                -Limits::min(),
                                TypeParam{1},
                                Limits::max(),
                                -Limits::max(),
                                Limits::max() / 2,
                                Limits::infinity(),
                                -Limits::infinity(),
                                canonical_nan<TypeParam>(),
                                3 * Limits::denorm_min()};
    for (const TypeParam x : values) {
        for (const TypeParam y : values) expect_exact(x, y);
    }
}

}  // namespace
}  // namespace stator::math
