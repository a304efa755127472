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

constexpr uint64_t kPeriod_us = 40'000;
constexpr uint64_t kNow_us = 1'500'000;

BaroRate climbing(float speed, unsigned samples, uint64_t from_us = 1'000'000) {
    BaroRate rate;
    for (unsigned i = 0; i < samples; ++i) {
        const uint64_t time_us = from_us + i * kPeriod_us;
        rate.add(time_us, 500.0F + speed * static_cast<float>(time_us) * 1e-6F);
    }
    return rate;
}

TEST(BaroRate, knows_nothing_before_it_has_eight_samples) {
    EXPECT_FALSE(climbing(1.0F, 7).known(kNow_us));
    EXPECT_TRUE(climbing(1.0F, 8).known(kNow_us));
}

TEST(BaroRate, is_not_known_of_a_sensor_that_is_silent) {
    const BaroRate rate = climbing(1.0F, 8);
    EXPECT_TRUE(rate.known(2'000'000));
    EXPECT_FALSE(rate.known(2'500'000));
}

TEST(Spike, leaves_out_one_sample_and_believes_two) {
    constexpr float kStep_s = 0.001F;
    Spike spike(1000.0F);
    const Vector usual(0.2F, -0.1F, 0.0F);
    const Vector far(3.5F, 3.2F, 3.3F);
    EXPECT_EQ(spike.without(usual, kStep_s), usual);
    EXPECT_EQ(spike.without(far, kStep_s), usual);
    EXPECT_EQ(spike.without(usual, kStep_s), usual);
    EXPECT_EQ(spike.without(far, kStep_s), usual);
    EXPECT_EQ(spike.without(far, kStep_s), far);
    EXPECT_EQ(spike.without(usual, 0.02F), usual);  // in so long a time it may change by so much
}

TEST(BaroRate, is_the_slope_of_the_height) {
    for (const float speed : {-3.0F, 0.0F, 0.5F, 12.0F})
        EXPECT_NEAR(climbing(speed, 30).value(), speed, 0.01F);
}

TEST(BaroRate, lets_noise_average_out) {
    BaroRate rate;
    for (unsigned i = 0; i < 8; ++i) rate.add(i * kPeriod_us + 1, (i % 2 == 0 ? 0.1F : -0.1F));
    EXPECT_LT(math::abs(rate.value()), 0.4F);  // two samples alone would say 5 m/s
}

TEST(BaroRate, begins_again_after_a_gap_and_after_a_clock_that_steps_back) {
    BaroRate rate = climbing(1.0F, 8);
    rate.add(1'000'000 + 7 * kPeriod_us + 200'001, 0.0F);
    EXPECT_FALSE(rate.known(kNow_us));
    rate = climbing(1.0F, 8);
    rate.add(1'000'000, 0.0F);
    EXPECT_FALSE(rate.known(kNow_us));
}

}  // namespace

}  // namespace stator::apps::navigation
