// What a switch does to the nodes of graphs/modes.yaml: at 55 ms mode `other` begins, at 105 ms
// mode `one`, and so on.
#include "events.hpp"
#include "apps/station/journal.hpp"
#include "tasks.hpp"

namespace stator {
namespace {

namespace journal = apps::station::journal;

using journal::Entry;

class ModesTest : public testing::GraphTest {};

TEST_F(ModesTest, only_the_nodes_of_the_mode_run) {
    run_until(260'000);
    for (const Entry& entry : journal::of(3)) {
        EXPECT_LE(entry.now_us % 100'000, entry.now_us < 100'000 ? 50'000U : 150'000U);
        const bool is_one = entry.now_us < 55'000 || entry.now_us / 50'000 % 2 == 0 ||
                            entry.now_us % 50'000 <= 5'000;
        EXPECT_TRUE(is_one) << entry.now_us;
    }
    for (const Entry& entry : journal::of(4)) {
        const uint64_t in_cycle = (entry.now_us + 45'000) % 100'000;
        EXPECT_LE(in_cycle, 50'000U) << entry.now_us;
    }
    EXPECT_GT(journal::of(3).size(), 10U);
    EXPECT_GT(journal::of(4).size(), 10U);
}

// A node is made anew each time it is switched on; one that is in both modes goes on.
TEST_F(ModesTest, a_node_begins_anew) {
    run_until(160'000);
    const std::vector<Entry> alpha = journal::of(3);
    ASSERT_EQ(alpha.size(), 11U);  // at 0, 10, .. 50 and 110, .. 150 ms
    EXPECT_EQ(alpha[5].activation, 6U);
    EXPECT_EQ(alpha[6].now_us, 110'000U);
    EXPECT_EQ(alpha[6].activation, 1U);
    EXPECT_EQ(journal::of(6).back().activation, 17U);
}

// What was published while a node was off is neither read nor lost.
TEST_F(ModesTest, a_trigger_begins_with_what_comes_after_the_switch) {
    run_until(160'000);
    const std::vector<Entry> alpha = journal::of(3);
    EXPECT_EQ(alpha[6].a_value, 12U);
    EXPECT_EQ(alpha[6].a_lost, 0U);
    EXPECT_EQ(tasks::alpha::state.counters.lost_samples, 0U);
}

TEST_F(ModesTest, a_queue_begins_empty) {
    run_until(70'000);
    const std::vector<Entry> beta = journal::of(4);
    ASSERT_EQ(beta.size(), 4U);
    // At 56, 60, 63 and 70 ms; ticks 7 and 8 are those of 60 and 70 ms.
    const std::vector<uint32_t> expected[] = {{}, {7}, {}, {8}};
    for (unsigned i = 0; i < 4; ++i) EXPECT_EQ(beta[i].b_values, expected[i]) << i;
    EXPECT_EQ(beta[0].b_lost, 0U);
}

TEST_F(ModesTest, periods_keep_their_phase) {
    run_until(70'000);
    const std::vector<Entry> beta = journal::of(4);
    ASSERT_EQ(beta.size(), 4U);
    const uint64_t expected[] = {56'000, 60'000, 63'000, 70'000};
    const uint32_t timers[] = {2, 1, 2, 2};
    for (unsigned i = 0; i < 4; ++i) {
        EXPECT_EQ(beta[i].now_us, expected[i]);
        EXPECT_EQ(beta[i].timers, timers[i]);
    }
}

// The switch happens inside the publication of `doomed`, which then ends as if nothing had been.
TEST_F(ModesTest, a_running_job_finishes) {
    run_until(60'000);
    EXPECT_NE(journal::order.find("+1 -1 "), std::string::npos);
    EXPECT_EQ(tasks::doomed::state.counters.activations, 1U);
    EXPECT_EQ(journal::of(4).front().now_us, 56'000U) << "the switch is done";
    run_until(160'000);
    EXPECT_EQ(journal::of(1).back().activation, 1U) << "and it begins anew";
    EXPECT_EQ(tasks::doomed::state.counters.activations, 2U);
}

// Every wish pends `late`, and every wish that it could read switches it off before it runs.
TEST_F(ModesTest, the_pending_bit_of_a_stopped_node_is_cleared) {
    run_until(1'000'000);
    EXPECT_EQ(tasks::late::state.counters.activations, 0U);
    EXPECT_TRUE(journal::of(7).empty());
    EXPECT_GE(journal::of(1).size(), 9U);
}

// Publishers of different modes on different levels share one topic, numbered in one order.
TEST_F(ModesTest, publishers_take_turns) {
    run_until(300'000);
    const std::vector<Entry> work = journal::of(5);
    EXPECT_EQ(work.size(), journal::of(3).size() + journal::of(4).size());
    for (const Entry& entry : work) EXPECT_EQ(entry.a_lost, 0U);
}

TEST_F(ModesTest, switches_hold_under_preemption) {
    use_random_times({.seed = 5, .most_us = 20});
    run_until(2'000'000);
    EXPECT_EQ(journal::torn, 0U);
    EXPECT_GE(journal::of(1).size(), 15U);
    EXPECT_EQ(
        tasks::watcher::state.counters.lost_samples + tasks::watcher::state.counters.activations,
        tasks::alpha::state.counters.activations + tasks::beta::state.counters.activations);
}

}  // namespace
}  // namespace stator
