// Seconds between steps: ordinary ones exact, odd ones within their limits.
#include "stator/elapsed.hpp"

#include <gtest/gtest.h>

namespace {

constexpr float kShortest = 1e-3F;
constexpr float kLongest = 0.1F;
constexpr uint64_t kStart_us = 1'000'000;

float seconds_from_start(uint64_t now_us) {
    uint64_t last_us = kStart_us;
    const float seconds = stator::seconds_since_last(last_us, now_us, kShortest, kLongest);
    EXPECT_EQ(last_us, now_us);
    return seconds;
}

TEST(SecondsSinceLast, is_the_time_between_two_steps) {
    EXPECT_EQ(seconds_from_start(kStart_us + 4'000), 4'000.0F * 1e-6F);
    EXPECT_EQ(seconds_from_start(kStart_us + 50'000), 50'000.0F * 1e-6F);
}

TEST(SecondsSinceLast, is_the_shortest_for_a_repeated_or_an_earlier_time) {
    EXPECT_EQ(seconds_from_start(kStart_us), kShortest);
    EXPECT_EQ(seconds_from_start(kStart_us - 1), kShortest);
    EXPECT_EQ(seconds_from_start(0), kShortest);
}

// 2^31 us are 35.8 min: an int32_t of them is negative; of 2^32 us and a bit more it is that bit.
TEST(SecondsSinceLast, is_the_longest_after_any_gap) {
    for (const unsigned bits : {20U, 31U, 32U, 33U, 62U}) {
        const uint64_t gap_us = uint64_t{1} << bits;
        EXPECT_EQ(seconds_from_start(kStart_us + gap_us - 1), kLongest) << bits;
        EXPECT_EQ(seconds_from_start(kStart_us + gap_us), kLongest) << bits;
        EXPECT_EQ(seconds_from_start(kStart_us + gap_us + 10), kLongest) << bits;
    }
}

}  // namespace
