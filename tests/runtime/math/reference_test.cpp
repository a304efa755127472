// Every function against the committed table of true values, in float and double.
#include <gtest/gtest.h>

#include <span>

#include "stator/scalar.hpp"
#include "ulp.hpp"

namespace stator::math {
namespace {

struct Reference {
    double x;
    double y;
    double high;
    double low;
};

#include "reference.inc"

template <typename T, typename Function>
void expect_within(double limit, std::span<const Reference> table, Function function) {
    double worst = 0.0;
    for (const Reference& row : table) {
        const T value = function(static_cast<T>(row.x), static_cast<T>(row.y));
        const double error = ulp_error(value, row.high, row.low);
        EXPECT_LE(error, limit) << std::hexfloat << "x " << row.x << " y " << row.y;
        worst = std::max(worst, error);
    }
    ::testing::Test::RecordProperty("largest_error_ulp", std::to_string(worst));
}

// One statement for both types; `limit` is README's figure, rounded up.
#define EXPECT_ACCURATE(name, limit, expression)                               \
    do {                                                                       \
        expect_within<float>(limit, k##name##Float, [](float x, float y) {     \
            static_cast<void>(y);                                              \
            return expression;                                                 \
        });                                                                    \
        expect_within<double>(limit, k##name##Double, [](double x, double y) { \
            static_cast<void>(y);                                              \
            return expression;                                                 \
        });                                                                    \
    } while (false)

TEST(Reference, Sin) {
    EXPECT_ACCURATE(Sin, 0.79, sin(x));
}
TEST(Reference, Cos) {
    EXPECT_ACCURATE(Cos, 0.79, cos(x));
}
TEST(Reference, SincosSin) {
    EXPECT_ACCURATE(Sin, 0.79, sincos(x).sin);
}
TEST(Reference, SincosCos) {
    EXPECT_ACCURATE(Cos, 0.79, sincos(x).cos);
}
TEST(Reference, Tan) {
    EXPECT_ACCURATE(Tan, 0.90, tan(x));
}
TEST(Reference, WrapPi) {
    EXPECT_ACCURATE(WrapPi, 0.52, wrap_pi(x));
}
TEST(Reference, Atan) {
    EXPECT_ACCURATE(Atan, 0.70, atan(x));
}
TEST(Reference, Asin) {
    EXPECT_ACCURATE(Asin, 0.67, asin(x));
}
TEST(Reference, Acos) {
    EXPECT_ACCURATE(Acos, 0.67, acos(x));
}
TEST(Reference, Exp) {
    EXPECT_ACCURATE(Exp, 0.76, exp(x));
}
TEST(Reference, Log) {
    EXPECT_ACCURATE(Log, 0.87, log(x));
}
TEST(Reference, Sqrt) {
    EXPECT_ACCURATE(Sqrt, 0.5, sqrt(x));
}
TEST(Reference, SqrtByIntegers) {
    EXPECT_ACCURATE(Sqrt, 0.5, detail::sqrt_by_integers(x));
}
TEST(Reference, Atan2) {
    EXPECT_ACCURATE(Atan2, 0.70, atan2(x, y));
}
TEST(Reference, Pow) {
    EXPECT_ACCURATE(Pow, 0.79, pow(x, y));
}

}  // namespace
}  // namespace stator::math
