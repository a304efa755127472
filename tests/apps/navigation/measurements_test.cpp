// What is remembered of measurements.
#include "measurements.hpp"

#include <gtest/gtest.h>

namespace stator::apps::navigation {

namespace {

TEST(Aid, is_recent_for_a_measurement_that_is_older) {
    Aid height;
    EXPECT_FALSE(height.recent(1'000'000, 1.0F));
    height.accept(2'000'000);
    EXPECT_TRUE(height.recent(3'000'000, 1.0F));
    EXPECT_FALSE(height.recent(3'000'001, 1.0F));
    EXPECT_TRUE(height.recent(1'900'000, 1.0F));
}

}  // namespace

}  // namespace stator::apps::navigation
