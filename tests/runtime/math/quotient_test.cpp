// Division of whole numbers into doubles, against the processor's own.
#include "stator/math/quotient.hpp"

#include <gtest/gtest.h>

#include "stator/random.hpp"

namespace stator::math {
namespace {

TEST(Quotient, is_what_the_processor_makes_of_numbers_that_it_holds_exactly) {
    Random random(5, 1);
    for (int i = 0; i < 200'000; ++i) {
        const auto shift = static_cast<unsigned>(52.0 * random.uniform_double());
        const auto magnitude = static_cast<int64_t>(0x1p52 * random.uniform_double()) >> shift;
        const int64_t numerator = i % 2 == 0 ? magnitude : -magnitude;
        const auto denominator = static_cast<uint32_t>(1.0 + 4e9 * random.uniform_double());
        ASSERT_EQ(quotient(numerator, denominator),
                  static_cast<double>(numerator) / static_cast<double>(denominator))
            << numerator << " / " << denominator;
    }
}

TEST(Quotient, is_right_at_the_edges) {
    EXPECT_EQ(quotient(0, 7), 0.0);
    EXPECT_EQ(quotient(1, 1), 1.0);
    EXPECT_EQ(quotient(-1, UINT32_MAX), -1.0 / 4294967295.0);
    EXPECT_EQ(quotient(INT64_MIN, 1), -0x1p63);
    EXPECT_EQ(quotient(INT64_MAX, 1), 0x1p63);               // rounded up
    EXPECT_EQ(quotient((int64_t{1} << 53) + 1, 1), 0x1p53);  // halfway, to even
    EXPECT_EQ(quotient((int64_t{1} << 53) + 3, 1), 0x1p53 + 4.0);
    EXPECT_EQ(quotient(4'739'774'600, 100'000'000), 47.397746);
}

}  // namespace
}  // namespace stator::math
