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
void expect_within(double largest, std::span<const Reference> table, Function function) {
    for (const Reference& row : table) {
        const T value = function(static_cast<T>(row.x), static_cast<T>(row.y));
        const double error = ulp_error(value, row.high, row.low);
        EXPECT_LE(error, largest) << std::hexfloat << "x " << row.x << " y " << row.y;
    }
}

// One statement for both types.
#define EXPECT_ACCURATE(name, expression)                                                     \
    do {                                                                                      \
        expect_within<float>(                                                                 \
            limit::k##name, k##name##Float,                                                   \
            []([[maybe_unused]] float x, [[maybe_unused]] float y) { return expression; });   \
        expect_within<double>(                                                                \
            limit::k##name, k##name##Double,                                                  \
            []([[maybe_unused]] double x, [[maybe_unused]] double y) { return expression; }); \
    } while (false)

TEST(Reference, Sin) {
    EXPECT_ACCURATE(Sin, sin(x));
}
TEST(Reference, Cos) {
    EXPECT_ACCURATE(Cos, cos(x));
}
TEST(Reference, SincosSin) {
    EXPECT_ACCURATE(Sin, sincos(x).sin);
}
TEST(Reference, SincosCos) {
    EXPECT_ACCURATE(Cos, sincos(x).cos);
}
TEST(Reference, Tan) {
    EXPECT_ACCURATE(Tan, tan(x));
}
TEST(Reference, WrapPi) {
    EXPECT_ACCURATE(WrapPi, wrap_pi(x));
}
TEST(Reference, Atan) {
    EXPECT_ACCURATE(Atan, atan(x));
}
TEST(Reference, Asin) {
    EXPECT_ACCURATE(Asin, asin(x));
}
TEST(Reference, Acos) {
    EXPECT_ACCURATE(Acos, acos(x));
}
TEST(Reference, Exp) {
    EXPECT_ACCURATE(Exp, exp(x));
}
TEST(Reference, Log) {
    EXPECT_ACCURATE(Log, log(x));
}
TEST(Reference, Sqrt) {
    EXPECT_ACCURATE(Sqrt, sqrt(x));
}
TEST(Reference, SqrtByIntegers) {
    EXPECT_ACCURATE(Sqrt, detail::sqrt_by_integers(x));
}
TEST(Reference, Atan2) {
    EXPECT_ACCURATE(Atan2, atan2(x, y));
}
TEST(Reference, Pow) {
    EXPECT_ACCURATE(Pow, pow(x, y));
}

}  // namespace
}  // namespace stator::math
