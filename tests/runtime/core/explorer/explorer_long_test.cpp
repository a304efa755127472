// All topologies of four levels under every schedule of seven activations, and longer searches of
// fewer levels.
#include <gtest/gtest.h>

#include "search.hpp"

namespace stator::explorer {
namespace {

constexpr uint32_t kBeforeWrap = 0xFFFFFFFDU;

void expect_pass(unsigned levels, unsigned depth, const Limits& limits, const Start& start) {
    uint64_t states = 0;
    for (const Topology& topology : all_topologies(levels, depth)) {
        const Verdict verdict = explore(topology, topology.slots(), limits, start);
        EXPECT_TRUE(verdict.has_passed()) << topology.name() << ": " << verdict.violation << "\n"
                                          << verdict.schedule;
        states += verdict.states;
    }
    std::printf("%u levels, depth %u: %llu states\n", levels, depth,
                static_cast<unsigned long long>(states));
}

class ExplorerLong : public testing::TestWithParam<unsigned> {};
INSTANTIATE_TEST_SUITE_P(Depth, ExplorerLong, testing::Values(1U, 2U, 4U),
                         testing::PrintToStringParamName());

TEST_P(ExplorerLong, four_levels_pass) {
    expect_pass(4, GetParam(), {}, {});
}

TEST_P(ExplorerLong, four_levels_with_a_full_history_pass_across_wrap_around) {
    expect_pass(4, GetParam(), {.activations = 5}, {kBeforeWrap, GetParam()});
}

TEST_P(ExplorerLong, three_levels_with_a_full_history_pass_across_wrap_around) {
    expect_pass(3, GetParam(), {}, {kBeforeWrap, GetParam()});
}

// Nothing is bounded where the search ends by itself; the others go on to a million states.
TEST(ExplorerLong, depth_1_passes_far_beyond_seven_activations) {
    unsigned complete = 0;
    const std::vector<Topology> all = all_topologies(3, 1);
    for (const Topology& topology : all) {
        const Limits limits{.activations = 200, .states = 1'000'000};
        const Verdict verdict = explore(topology, topology.slots(), limits, {});
        EXPECT_EQ(verdict.violation, "") << topology.name() << "\n" << verdict.schedule;
        complete += verdict.is_complete ? 1U : 0U;
    }
    std::printf("%u of %zu topologies complete\n", complete, all.size());
    EXPECT_GE(complete, 100U);
}

}  // namespace
}  // namespace stator::explorer
