// Life signs: who is missed, when, and what a switched-off node does not owe.
#include "stator/watch.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "stator/events.hpp"

namespace {

using namespace stator;

constexpr uint32_t kWindow_us = 100;

struct Watch : ::testing::Test {
    TaskCounters counters;
    WatchState state;
    ModeGate gate;
    Watched row{"task", 0, &counters, &state, kWindow_us, nullptr};

    void live() { ++counters.activations; }
};

TEST_F(Watch, a_task_that_lives_within_its_window_is_never_missed) {
    for (uint64_t now_us = 100; now_us <= 10'000; now_us += 100) {
        EXPECT_FALSE(misses_life_sign(row, now_us));
        live();
    }
    EXPECT_EQ(state.missed, 0U);
}

TEST_F(Watch, a_silent_task_is_missed_once_for_each_window) {
    EXPECT_FALSE(misses_life_sign(row, 100));
    EXPECT_TRUE(misses_life_sign(row, 101));
    EXPECT_TRUE(state.is_silent);
    EXPECT_FALSE(misses_life_sign(row, 201));
    EXPECT_TRUE(misses_life_sign(row, 202));
    EXPECT_EQ(state.missed, 2U);
}

TEST_F(Watch, a_new_life_sign_ends_the_silence) {
    EXPECT_TRUE(misses_life_sign(row, 101));
    live();
    EXPECT_FALSE(misses_life_sign(row, 102));
    EXPECT_FALSE(state.is_silent);
    EXPECT_FALSE(misses_life_sign(row, 202));
    EXPECT_TRUE(misses_life_sign(row, 203));
}

TEST_F(Watch, a_node_that_its_mode_switched_off_owes_no_life_sign) {
    row.gate = &gate;
    EXPECT_FALSE(misses_life_sign(row, 5'000));
    gate.epoch.store(1);
    EXPECT_FALSE(misses_life_sign(row, 5'100));
    EXPECT_TRUE(misses_life_sign(row, 5'101));
}

TEST(LogEvents, come_in_order_and_once) {
    LogEvents events;
    LogEvent event;
    uint32_t cursor = 0;
    EXPECT_FALSE(events.next(cursor, event));
    events.add({1, "one", ""});
    events.add({2, "two", ""});
    std::vector<std::string> read;
    while (events.next(cursor, event)) read.emplace_back(event.what);
    EXPECT_EQ(read, (std::vector<std::string>{"one", "two"}));
}

TEST(LogEvents, keep_the_newest_for_a_reader_that_lags) {
    LogEvents events;
    for (uint64_t i = 0; i < 100; ++i) events.add({i, "", ""});
    LogEvent event;
    uint32_t cursor = 0;
    ASSERT_TRUE(events.next(cursor, event));
    EXPECT_EQ(event.time_us, 85U);  // 15 can be read while the 16th is written
    while (events.next(cursor, event)) {
    }
    EXPECT_EQ(event.time_us, 99U);
}

}  // namespace
