// When and in which order the nodes of graphs/order.yaml run, and what they read.
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <sstream>
#include <vector>

#include "apps/station/journal.hpp"
#include "events.hpp"
#include "tasks.hpp"

namespace stator {
namespace {

namespace journal = apps::station::journal;

using journal::Entry;

class OrderTest : public testing::GraphTest {};

// The journal without the stations of other parts.
std::string order_of(const std::vector<std::string>& ids) {
    std::string kept;
    for (std::size_t at = 0; at < journal::order.size();) {
        const std::size_t end = journal::order.find(' ', at);
        const std::string word = journal::order.substr(at, end - at);
        for (const std::string& id : ids) {
            if (word.substr(1) == id) kept += word + " ";
        }
        at = end + 1;
    }
    return kept;
}

// The more urgent level first, inside a level the order of the graph; a publication that wakes a
// more urgent node runs it inside the publishing call, one that wakes a peer after its end.
TEST_F(OrderTest, levels_nest_and_peers_wait) {
    run_until(0);
    EXPECT_EQ(order_of({"1", "2", "3", "4", "5"}), "+2 -2 +3 -3 +1 +4 -4 -1 +5 -5 ");
    run_until(10'000);
    EXPECT_EQ(journal::of(1).size(), 2U);
    EXPECT_EQ(journal::of(5).back().now_us, 10'000U);
}

TEST_F(OrderTest, an_activation_consumes_one_sample_and_wakes_itself_for_the_next) {
    run_until(1'000);
    EXPECT_EQ(order_of({"10", "11"}), "+10 -10 +11 -11 +11 -11 +11 -11 ");
    const std::vector<Entry> taken = journal::of(11);
    ASSERT_EQ(taken.size(), 3U);
    for (uint32_t i = 0; i < 3; ++i) {
        EXPECT_EQ(taken[i].a_value, i + 1);
        EXPECT_EQ(taken[i].now_us, 1'000U);
        EXPECT_TRUE(taken[i].a_is_new);
        EXPECT_EQ(taken[i].a_lost, 0U);
    }
    EXPECT_EQ(tasks::taker::state.counters.activations, 3U);
}

TEST_F(OrderTest, what_exceeds_the_burst_is_refused_and_counted) {
    run_until(2'000);
    EXPECT_EQ(journal::of(16).size(), 6U);
    EXPECT_EQ(tasks::greedy::state.counters.lost_samples, 3U);
    EXPECT_EQ(refused_publications.count.load(), 3U);
    EXPECT_STREQ(refused_publications.newest.load(), "greedy.out");
    EXPECT_EQ(tasks::flood::state.counters.lost_samples, 0U);
    run_until(102'000);
    EXPECT_EQ(tasks::greedy::state.counters.lost_samples, 6U);
}

TEST_F(OrderTest, what_the_depth_cannot_hold_is_counted_as_lost) {
    run_until(2'000);
    const std::vector<Entry> taken = journal::of(13);
    ASSERT_EQ(taken.size(), 4U);
    EXPECT_EQ(taken[0].a_value, 3U);
    EXPECT_EQ(taken[0].a_lost, 2U);
    EXPECT_EQ(taken[3].a_value, 6U);
    EXPECT_EQ(tasks::drain::state.counters.lost_samples, 2U);
    run_until(102'000);
    EXPECT_EQ(tasks::drain::state.counters.lost_samples, 4U);
}

// A list of triggers: each activates, and `fired` says which timer it was.
TEST_F(OrderTest, any_trigger_of_a_list_activates) {
    run_until(10'000);
    const std::vector<Entry> seen = journal::of(14);
    ASSERT_EQ(seen.size(), 6U);
    const uint64_t expected_now[] = {0, 1'000, 1'000, 1'000, 3'000, 10'000};
    const uint32_t expected_timers[] = {2, 0, 0, 0, 1, 3};
    for (unsigned i = 0; i < 6; ++i) {
        EXPECT_EQ(seen[i].now_us, expected_now[i]) << i;
        EXPECT_EQ(seen[i].timers, expected_timers[i]) << i;
        EXPECT_EQ(seen[i].has_a, expected_timers[i] == 0) << i;
    }
}

TEST_F(OrderTest, timers_are_released_at_their_offset_and_never_drift) {
    run_until(1'000'000);
    const std::vector<Entry> seen = journal::of(31);
    ASSERT_EQ(seen.size(), 100U);
    for (std::size_t i = 0; i < seen.size(); ++i) EXPECT_EQ(seen[i].now_us, 5'000 + i * 10'000);
}

// 3 ms thinned to 10 ms: the first sample at or after each multiple of 10 ms.
TEST_F(OrderTest, a_thinned_trigger_keeps_the_mean_rate) {
    run_until(2'999'000);
    const std::vector<Entry> seen = journal::of(21);
    ASSERT_EQ(seen.size(), 300U);
    for (std::size_t i = 0; i < seen.size(); ++i) {
        EXPECT_EQ(seen[i].now_us, (i * 10'000 + 2'999) / 3'000 * 3'000) << i;
    }
    EXPECT_EQ(seen[1].a_lost, 3U);  // from the sample at 0 to that at 12 ms
}

TEST_F(OrderTest, a_queue_is_read_in_order_and_completely) {
    run_until(301'000);
    uint32_t expected = 0;
    for (const Entry& entry : journal::of(22)) {
        for (const uint32_t value : entry.b_values) {
            ++expected;
            EXPECT_EQ(value, expected);
        }
        EXPECT_EQ(entry.b_lost, 0U);
    }
    EXPECT_EQ(expected, 101U);
    EXPECT_EQ(tasks::collector::state.counters.lost_samples, 0U);
}

TEST_F(OrderTest, a_sample_older_than_its_limit_reads_as_absent) {
    run_until(199'000);
    for (const Entry& entry : journal::of(31)) {
        EXPECT_EQ(entry.has_a, entry.now_us % 100'000 <= 20'000) << entry.now_us;
    }
}

TEST_F(OrderTest, several_publishers_reach_every_reader_in_one_order) {
    run_until(990'000);
    const std::vector<Entry> above = journal::of(43);
    const std::vector<Entry> below = journal::of(44);
    ASSERT_EQ(above.size(), 299U);
    ASSERT_EQ(below.size(), 299U);
    for (std::size_t i = 0; i < above.size(); ++i) {
        EXPECT_EQ(above[i].a_value, below[i].a_value);
        EXPECT_EQ(above[i].a_source, below[i].a_source);
        EXPECT_EQ(above[i].a_lost + below[i].a_lost, 0U);
    }
    EXPECT_EQ(above[0].a_source, 41U);
    EXPECT_EQ(above[1].a_source, 40U);
    EXPECT_EQ(above[2].a_source, 42U);
}

TEST_F(OrderTest, every_node_has_its_own_parameters) {
    run_until(100'000);
    for (const int id :
         {1, 2, 3, 4, 5, 10, 11, 12, 13, 14, 20, 21, 22, 30, 31, 40, 41, 42, 43, 44}) {
        EXPECT_FALSE(journal::of(id).empty()) << id;
    }
    EXPECT_TRUE(journal::of(0).empty());
}

// --- activations that take time ---

// How often a station began before another one ended.
unsigned times_inside_another(const std::string& id) {
    unsigned times = 0;
    unsigned active = 0;
    std::istringstream words(journal::order);
    for (std::string word; words >> word;) {
        times += word == "+" + id && active != 0 ? 1U : 0U;
        active = word[0] == '+' ? active + 1 : active - 1;
    }
    return times;
}

void run_with_seed(uint64_t seed) {
    use_random_times({.seed = seed, .most_us = 60});
    run_until(2'000'000);
}

TEST_F(OrderTest, without_durations_only_a_publication_preempts) {
    run_until(300'000);
    EXPECT_EQ(times_inside_another("20"), 0U);
    EXPECT_EQ(times_inside_another("4"), 31U);  // woken by each publication of `low`
}

TEST_F(OrderTest, preemption_never_tears_a_sample_and_changes_no_nominal_time) {
    run_with_seed(1);
    EXPECT_EQ(journal::torn, 0U);
    bool was_late = false;
    for (const Entry& entry : journal::of(1)) {
        EXPECT_EQ(entry.now_us % 10'000, 0U);
        was_late = was_late || entry.clock_us > entry.now_us;
    }
    EXPECT_TRUE(was_late) << "no activation took time";
    EXPECT_GT(times_inside_another("20"), 10U);
}

// `collector` has 5 ms, the more urgent `ticker` 0.1 ms: released at 1 ms, `collector` is
// interrupted by the ticks of 3 and 6 ms and ends at 6.2 ms; `chooser` of its level, released at
// 3 ms, begins then.
TEST_F(OrderTest, activations_take_their_budgets_and_are_preempted_when_others_are_due) {
    std::vector<uint32_t> budgets(program.task_count, 0);
    for (unsigned i = 0; i < program.task_count; ++i) {
        const std::string name = program.tasks[i].name;
        budgets[i] = name == "collector" ? 5'000 : name == "ticker" ? 100 : 0;
    }
    use_budgets(budgets);
    run_until(100'000);
    const std::vector<Entry> chosen = journal::of(14);
    const auto late = std::find_if(chosen.begin(), chosen.end(),
                                   [](const Entry& entry) { return entry.now_us == 3'000; });
    ASSERT_NE(late, chosen.end());
    EXPECT_EQ(late->clock_us, 6'200U);
    // In the middle, once an activation has shown how many points there are.
    EXPECT_GT(times_inside_another("20"), 2U);
    EXPECT_EQ(journal::torn, 0U);
}

// What happened in a run of its own process, as a graph starts only once: a digest.
int digest_of_seed(uint64_t seed) {
    const pid_t child = fork();
    if (child == 0) {
        run_with_seed(seed);
        _exit(static_cast<int>(std::hash<std::string>()(journal::order) % 251));
    }
    int status = -1;
    EXPECT_EQ(waitpid(child, &status, 0), child);
    EXPECT_TRUE(WIFEXITED(status));
    return status;
}

TEST_F(OrderTest, a_seed_decides_all_that_happens) {
    const int seventh = digest_of_seed(7);
    EXPECT_EQ(digest_of_seed(7), seventh);
    EXPECT_NE(digest_of_seed(8), seventh);
}

}  // namespace
}  // namespace stator
