// A device's line: when its driver runs, and what is counted when it comes too early.
#include "board.hpp"
#include "events.hpp"
#include "tasks.hpp"

namespace stator {

namespace board {
drivers::button::test::ButtonTest::Device button0;
Line button0_pressed;
}  // namespace board

namespace {

class LinesTest : public testing::GraphTest {
  protected:
    void press_at(const std::vector<uint64_t>& times_us) {
        for (const uint64_t time_us : times_us) {
            testing::events.emplace(time_us, [] { board::button0_pressed.raise(); });
        }
    }
    const LineState& line() const { return tasks::button0::state.line_pressed; }
};

TEST_F(LinesTest, a_line_activates_its_driver_at_the_clock) {
    press_at({10'000, 25'123});
    run_until(20'000);
    EXPECT_EQ(board::button0.served, 1U);
    EXPECT_EQ(board::button0.last_now_us, 10'000U);
    run_until(30'000);
    EXPECT_EQ(board::button0.served, 2U);
    EXPECT_EQ(board::button0.last_now_us, 25'123U);
    EXPECT_EQ(line().early, 0U);
}

TEST_F(LinesTest, the_first_event_is_never_early) {
    press_at({0, 500});
    run_until(1'000);
    EXPECT_EQ(line().early, 1U);
    EXPECT_EQ(line().dropped, 0U);
}

// One late event makes the next look early, so a single early one is served.
TEST_F(LinesTest, an_early_event_is_counted_and_dropped_only_after_another) {
    press_at({10'000, 11'000, 11'900, 12'700, 13'700, 14'600});
    run_until(11'950);
    EXPECT_EQ(line().early, 1U);
    EXPECT_EQ(line().dropped, 0U);
    EXPECT_EQ(board::button0.served, 3U);
    run_until(12'800);
    EXPECT_EQ(line().early, 2U);
    EXPECT_EQ(line().dropped, 1U);
    EXPECT_EQ(board::button0.served, 3U);
    run_until(20'000);
    EXPECT_EQ(line().early, 3U);
    EXPECT_EQ(line().dropped, 1U);
    EXPECT_EQ(board::button0.served, 5U);
}

TEST_F(LinesTest, events_of_one_instant_are_one_activation) {
    press_at({10'000, 10'000});
    run_until(20'000);
    EXPECT_EQ(board::button0.served, 1U);
    EXPECT_EQ(line().early, 1U);
}

}  // namespace
}  // namespace stator
