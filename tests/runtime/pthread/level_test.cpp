// Levels as threads: order inside a level, pends that must not get lost, releases, start and end.
#include <chrono>
#include <csignal>
#include <filesystem>
#include <thread>

#include "figures.hpp"
#include "internal.hpp"
#include "program.hpp"

namespace stator {
namespace {

using testing::jobs;
using testing::kPends;
using testing::wait_for;

class LevelTest : public ::testing::Test {};

std::ptrdiff_t threads() {
    namespace fs = std::filesystem;
    return std::distance(fs::directory_iterator("/proc/self/task"), fs::directory_iterator());
}

TEST_F(LevelTest, tasks_of_a_level_run_in_planned_order_and_to_completion) {
    std::string order;
    jobs[3] = [&] {
        order += "b";
        if (order.size() == 6) return;
        set_pending(kPends[3]);
        set_pending(kPends[2]);
    };
    jobs[2] = [&] { order += "a"; };
    set_pending(kPends[3]);
    set_pending(kPends[2]);
    ASSERT_TRUE(testing::start_unhurried());
    ASSERT_TRUE(wait_until_idle(testing::kForever_us));
    EXPECT_TRUE(finish());
    EXPECT_EQ(order, "ababab") << "the first bit first, peers after the job";
}

// A level that has not come to its first round is not at rest, and an end that comes before that
// does not take the releases of the start away.
TEST_F(LevelTest, what_is_released_at_the_start_is_served) {
    unsigned served = 0;
    jobs[4] = [&] { served += served_now(testing::timer_state, 1000) ? 1U : 0U; };
    ask_permission({.real_time = false});
    for (unsigned level = 0; level < program.level_count; ++level) ASSERT_TRUE(make_level(level));
    EXPECT_TRUE(is_any_level_busy());
    stop_releases();
    open_gate(1.0);
    ASSERT_TRUE(wait_until_idle(testing::kForever_us));
    for (unsigned level = 0; level < program.level_count; ++level) {
        stop_level(level);
        EXPECT_TRUE(join_level(level, testing::kForever_us));
    }
    EXPECT_EQ(served, 1U);
}

// The link looks while the task is in the middle of counting.
TEST_F(LevelTest, figures_are_of_whole_activations) {
    TaskCounters& counters = *program.tasks[0].counters;
    std::atomic<bool> is_in_the_middle{false};
    std::atomic<bool> may_end{false};
    jobs[0] = [&] {
        counters.activations = 1;
        is_in_the_middle.store(true);
        while (!may_end.load()) std::this_thread::yield();
        counters.last_ticks = 1;
    };
    set_pending(kPends[0]);
    ASSERT_TRUE(testing::start_unhurried());
    ASSERT_TRUE(wait_for([&] { return is_in_the_middle.load(); }));
    EXPECT_EQ(figures_of_task(0).activations, 0U);
    may_end.store(true);
    ASSERT_TRUE(wait_until_idle(testing::kForever_us));
    EXPECT_EQ(figures_of_task(0).activations, 1U);
    EXPECT_EQ(figures_of_task(0).last_ticks, 1U);
    EXPECT_TRUE(finish());
}

TEST(FiguresTest, a_reader_never_sees_two_activations) {
    Figures figures;
    std::thread level([&] {
        for (uint32_t i = 1; i <= 300'000; ++i) figures.keep({i, i, i, i, i, i});
    });
    unsigned torn = 0;
    for (TaskCounters seen; seen.activations != 300'000;) {
        if (!figures.read(seen)) continue;
        const uint32_t count = seen.activations;
        torn += seen.lost_samples != count || seen.ticks != count || seen.last_ticks != count ||
                        seen.most_ticks != count || seen.latest_us != count
                    ? 1U
                    : 0U;
    }
    level.join();
    EXPECT_EQ(torn, 0U);
}

// Each pend comes after a count; whoever is pended last sees the last count.
TEST_F(LevelTest, no_pend_is_lost) {
    constexpr unsigned kCount = 50'000;
    std::atomic<unsigned> published{0};
    unsigned seen = 0;
    unsigned activations = 0;
    jobs[0] = [&] {
        seen = published.load(std::memory_order_relaxed);
        ++activations;
    };
    ASSERT_TRUE(testing::start_unhurried());
    std::thread others[2];
    for (std::thread& other : others) {
        other = std::thread([&] {
            for (unsigned i = 0; i < kCount; ++i) {
                published.fetch_add(1, std::memory_order_relaxed);
                set_pending(kPends[0]);
            }
        });
    }
    for (std::thread& other : others) other.join();
    ASSERT_TRUE(wait_until_idle(testing::kForever_us));
    EXPECT_EQ(seen, 2 * kCount);
    EXPECT_LE(activations, 2 * kCount);
    EXPECT_TRUE(finish());
}

// From level to level and back, so that each falls asleep again and again.
TEST_F(LevelTest, levels_that_wake_each_other_come_to_no_standstill) {
    constexpr unsigned kRounds = 5'000;
    unsigned rounds = 0;
    jobs[0] = [&] { set_pending(kPends[5]); };
    jobs[5] = [&] {
        if (++rounds < kRounds) set_pending(kPends[0]);
    };
    ASSERT_TRUE(testing::start_unhurried());
    set_pending(kPends[0]);
    ASSERT_TRUE(wait_until_idle(testing::kForever_us));
    EXPECT_TRUE(finish());
    EXPECT_EQ(rounds, kRounds);
    EXPECT_GE(facts_of_level(0).wakes + facts_of_level(2).wakes, 1U);
}

TEST_F(LevelTest, every_release_is_served_or_counted) {
    unsigned activations = 0;
    jobs[4] = [&] {
        if (!served_now(testing::timer_state, 1000)) return;
        EXPECT_EQ(nominal_time_us(testing::timer_state, 1000, 0) % 1000, 0U);
        EXPECT_LE(nominal_time_us(testing::timer_state, 1000, 0), clock_us());
        if (++activations % 10 == 0) sleep_until_us(clock_us() + 3'500);
    };
    ASSERT_TRUE(testing::start_unhurried());
    EXPECT_EQ(wait_until(200'000), Ending::kTime);
    EXPECT_TRUE(finish());
    EXPECT_GT(testing::timer_state.missed, 0U);
    EXPECT_EQ(activations + testing::timer_state.missed, testing::timer_state.fires.load());
    // Absolute: those of 0 to 200 ms, whatever was late; some more until it had ended.
    EXPECT_GE(testing::timer_state.fires.load(), 201U);
}

// Releases, sleeps and the end all follow the slower clock: of 100 ms of the machine, no more than
// 20 have passed for the graph.
TEST_F(LevelTest, a_slower_clock_is_slower_in_all) {
    constexpr double kSpeed = 0.2;
    jobs[4] = [&] {
        if (!served_now(testing::timer_state, 1000)) return;
        EXPECT_LE(nominal_time_us(testing::timer_state, 1000, 0), clock_us());
    };
    const auto begin = std::chrono::steady_clock::now();
    const auto most_us = [&] {
        const auto passed = std::chrono::steady_clock::now() - begin;
        return kSpeed * std::chrono::duration<double, std::micro>(passed).count();
    };
    ASSERT_TRUE(testing::start_unhurried(kSpeed));
    sleep_until_us(10'000);
    EXPECT_GE(clock_us(), 10'000U);
    EXPECT_LE(static_cast<double>(clock_us()), most_us());
    EXPECT_EQ(wait_until(20'000), Ending::kTime);
    EXPECT_GE(clock_us(), 20'000U);
    EXPECT_LE(static_cast<double>(clock_us()), most_us());
    EXPECT_TRUE(finish());
    EXPECT_GE(testing::timer_state.fires.load(), 21U);
    EXPECT_LE(static_cast<double>(testing::timer_state.fires.load()), most_us() * 1e-3 + 1.0);
}

TEST_F(LevelTest, what_is_pending_at_the_end_still_runs) {
    unsigned runs = 0;
    jobs[0] = [&] { set_pending(kPends[5]); };
    jobs[5] = [&] {
        sleep_until_us(clock_us() + 20'000);
        ++runs;
    };
    ASSERT_TRUE(testing::start_unhurried());
    set_pending(kPends[0]);
    EXPECT_TRUE(finish());
    EXPECT_EQ(runs, 1U);
}

TEST_F(LevelTest, no_thread_is_left) {
    std::thread([] {}).join();  // makes the sanitizer start its own
    const std::ptrdiff_t before = threads();
    ASSERT_TRUE(testing::start_unhurried());
    EXPECT_EQ(threads(), before + 4);
    EXPECT_TRUE(finish());
    EXPECT_EQ(threads(), before);
}

TEST_F(LevelTest, a_signal_ends_the_wait) {
    ASSERT_TRUE(testing::start_unhurried());
    kill(getpid(), SIGTERM);
    EXPECT_EQ(wait_until(testing::kForever_us), Ending::kSignal);
    EXPECT_EQ(ending_signal(), SIGTERM);
    EXPECT_TRUE(finish());
}

TEST_F(LevelTest, a_task_ends_the_wait) {
    jobs[5] = [] { stop(); };
    set_pending(kPends[5]);
    ASSERT_TRUE(testing::start_unhurried());
    EXPECT_EQ(wait_until(testing::kForever_us), Ending::kStopped);
    EXPECT_TRUE(finish());
}

// Self-made: a task that pends itself for ever. The end comes all the same, and says so.
TEST_F(LevelTest, what_does_not_come_to_rest_is_told) {
    jobs[5] = [] {
        set_pending(kPends[5]);
        sleep_until_us(clock_us() + 100);
    };
    set_pending(kPends[5]);
    ASSERT_TRUE(testing::start_unhurried());
    EXPECT_FALSE(finish());
    for (unsigned level = 0; level < 3; ++level) EXPECT_EQ(unended_task(level), nullptr);
}

// What a task that does not end leaves: its name, the other levels' end, and a process that signals
// end again.
TEST_F(LevelTest, a_task_that_does_not_end_is_left_and_named) {
    std::atomic<bool> goes_on{true};
    jobs[2] = [&] {
        while (goes_on) sleep_until_us(clock_us() + 100);
    };
    set_pending(kPends[2]);
    ASSERT_TRUE(testing::start_unhurried());
    EXPECT_FALSE(finish());
    EXPECT_EQ(unended_task(0), nullptr);
    ASSERT_NE(unended_task(1), nullptr);
    EXPECT_STREQ(unended_task(1)->name, "driver");
    EXPECT_EQ(unended_task(2), nullptr);
    sigset_t blocked;
    pthread_sigmask(SIG_BLOCK, nullptr, &blocked);
    EXPECT_EQ(sigismember(&blocked, SIGINT), 0);
    EXPECT_EQ(sigismember(&blocked, SIGTERM), 0);
    goes_on = false;
    EXPECT_TRUE(join_level(1, testing::kForever_us));
    EXPECT_EQ(unended_task(1), nullptr);
}

}  // namespace
}  // namespace stator
