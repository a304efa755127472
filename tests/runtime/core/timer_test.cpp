// Periodic triggers whose count of releases passes 2^32.
#include <gtest/gtest.h>

#include "stator/task.hpp"
#include "stator/virtual.hpp"

namespace stator {
namespace {

constexpr uint64_t kWrap = uint64_t{1} << 32;
constexpr uint32_t kPeriod_us = 1000;
constexpr uint32_t kOffset_us = 300;

class TimerTest : public testing::Test {
  protected:
    TimerTest() {
        executor.pending = &pending_;
        executor.words = 1;
    }
    uint64_t pending_ = 0;
    TimerState state_{.fires = Shared<uint32_t>(UINT32_MAX),
                      .served = UINT32_MAX,
                      .released_us = (kWrap - 1) * kPeriod_us,
                      .served_us = (kWrap - 1) * kPeriod_us};
    Timer timer_{&state_, kPeriod_us, kOffset_us, Pend{0, 1}};
};

TEST_F(TimerTest, releases_go_on_past_two_to_the_32) {
    EXPECT_EQ(next_release_us(timer_), kOffset_us + (kWrap - 1) * kPeriod_us);
    release(timer_);
    EXPECT_EQ(pending_, 1U);
    EXPECT_EQ(next_release_us(timer_), kOffset_us + kWrap * kPeriod_us);
    EXPECT_TRUE(served_now(state_, kPeriod_us));
    EXPECT_EQ(nominal_time_us(state_, kPeriod_us, kOffset_us),
              kOffset_us + (kWrap - 1) * kPeriod_us);
    EXPECT_FALSE(served_now(state_, kPeriod_us));
}

TEST_F(TimerTest, several_releases_are_served_as_one_at_the_newest_time) {
    for (int i = 0; i < 3; ++i) release(timer_);
    EXPECT_TRUE(served_now(state_, kPeriod_us));
    EXPECT_EQ(nominal_time_us(state_, kPeriod_us, kOffset_us),
              kOffset_us + (kWrap + 1) * kPeriod_us);
}

TEST_F(TimerTest, what_was_released_before_a_start_is_not_served) {
    release(timer_);
    skip_to(state_, state_.fires.load(), kPeriod_us);
    EXPECT_FALSE(served_now(state_, kPeriod_us));
}

}  // namespace
}  // namespace stator
