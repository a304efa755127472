// Topologies of up to three levels under every schedule of seven activations, and what the explorer
// must find where a slot or a line of the code is missing. Four levels: explorer_long_test.cpp.
#include <gtest/gtest.h>

#include "search.hpp"

namespace stator::explorer {
namespace {

constexpr unsigned kDepths[] = {1, 2, 4};
// Three samples before the number of the newest wraps to 0.
constexpr uint32_t kBeforeWrap = 0xFFFFFFFDU;

std::vector<Topology> up_to_three_levels(unsigned depth) {
    std::vector<Topology> all;
    for (const unsigned levels : {1U, 2U, 3U}) {
        const std::vector<Topology> more = all_topologies(levels, depth);
        all.insert(all.end(), more.begin(), more.end());
    }
    return all;
}

void expect_pass(const Topology& topology, const Limits& limits, const Start& start = {}) {
    const Verdict verdict = explore(topology, topology.slots(), limits, start);
    EXPECT_TRUE(verdict.has_passed()) << topology.name() << ": " << verdict.violation << "\n"
                                      << verdict.schedule;
    EXPECT_GT(verdict.states, 0U);
}

class ExplorerDepth : public testing::TestWithParam<unsigned> {};
INSTANTIATE_TEST_SUITE_P(Depth, ExplorerDepth, testing::ValuesIn(kDepths),
                         testing::PrintToStringParamName());

TEST_P(ExplorerDepth, three_levels_with_the_formulas_slots_pass) {
    for (const Topology& topology : up_to_three_levels(GetParam())) expect_pass(topology, {});
}

TEST_P(ExplorerDepth, three_levels_with_a_full_history_pass_across_wrap_around) {
    const Start start{kBeforeWrap, GetParam()};
    for (const Topology& topology : up_to_three_levels(GetParam())) {
        expect_pass(topology, {.activations = 5}, start);
    }
}

TEST_P(ExplorerDepth, levels_with_two_users_pass) {
    for (const unsigned levels : {1U, 2U}) {
        for (const Topology& topology : shared_level_topologies(levels, GetParam())) {
            expect_pass(topology, {});
        }
    }
}

// A publisher that reads its own topic holds its sample while it publishes again and again.
TEST_P(ExplorerDepth, readers_of_their_own_topic_that_publish_often_pass) {
    for (unsigned burst = 2; burst <= 5; ++burst) {
        for (const unsigned levels : {1U, 2U}) {
            for (const auto& some : {all_topologies(levels, GetParam()),
                                     shared_level_topologies(levels, GetParam())}) {
                for (const Topology& topology : with_burst(some, burst)) {
                    expect_pass(topology, {.activations = 4});
                }
            }
        }
    }
    for (const Topology& topology : with_burst(all_topologies(3, GetParam()), 2)) {
        expect_pass(topology, {.activations = 4});
    }
}

TEST_P(ExplorerDepth, some_of_four_levels_pass) {
    for (const char* users : {"1r 2q 3w 4q", "1w 2r 3b 4q", "1q 2w 3B 4w", "1r 2w 3w 4r",
                              "1r 2b 3r 4w", "1b 2q 3r 4r", "1q 2q 3q 4B", "1w 2w 3w 4q"}) {
        expect_pass(parse_topology(users, GetParam()), {});
    }
}

// For each topology one schedule: the compiler's formula is exact, not only enough.
TEST_P(ExplorerDepth, one_slot_less_fails_under_the_constructed_schedule) {
    std::vector<Topology> all = up_to_three_levels(GetParam());
    for (const auto& more : {all_topologies(4, GetParam()), shared_level_topologies(1, GetParam()),
                             shared_level_topologies(2, GetParam())}) {
        all.insert(all.end(), more.begin(), more.end());
    }
    EXPECT_EQ(all.size(), 3U + 21U + 117U + 528U + 8U + 97U);
    const std::vector<Topology> once = all;
    for (unsigned burst = 2; burst <= 6; ++burst) {
        const std::vector<Topology> more = with_burst(once, burst);
        EXPECT_EQ(more.size(), 669U);
        all.insert(all.end(), more.begin(), more.end());
    }
    for (const Topology& topology : all) {
        EXPECT_EQ(run_constructed(topology, topology.slots()).violation, "") << topology.name();
        EXPECT_EQ(run_constructed(topology, topology.slots() - 1).violation, "topic: no free slot")
            << topology.name();
    }
}

// At depth 1 the search ends by itself: no activation reaches a new state, so nothing is bounded.
TEST(Explorer, depth_1_passes_with_unbounded_activations) {
    for (const char* users :
         {"1r 2w", "1r 2r 3w", "1r 2w 3r", "1w 2b 3q", "1b 2w 3r", "1r 2b 3r", "1w 2w 3w"}) {
        const Topology topology = parse_topology(users, 1);
        const Verdict verdict = explore(topology, topology.slots(), {.activations = 200}, {});
        EXPECT_EQ(verdict.violation, "") << users;
        EXPECT_TRUE(verdict.is_complete) << users << ": " << verdict.states << " states";
    }
}

TEST(Explorer, finds_the_missing_slot_by_itself) {
    for (const char* users :
         {"1r 2w", "1w 2r", "1q 2w", "1b 2w", "1w 2w", "1r 2r 3w", "1b3 2r", "1B2 2r"}) {
        for (const unsigned depth : {1U, 2U}) {
            const Topology topology = parse_topology(users, depth);
            const Verdict verdict = explore(topology, topology.slots() - 1, {}, {});
            EXPECT_EQ(verdict.violation, "topic: no free slot") << topology.name();
        }
    }
}

}  // namespace
}  // namespace stator::explorer
