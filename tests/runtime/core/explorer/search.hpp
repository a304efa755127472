// Every schedule of a topology: all states that up to so many activations can reach.
#pragma once

#include <cstdint>
#include <string>

#include "topology.hpp"

namespace stator::explorer {

struct Limits {
    unsigned activations = 7;
    uint64_t states = UINT64_MAX;
};

// Where a run begins: with a history that full, the next number after `first`.
struct Start {
    uint32_t first = 0;
    unsigned published = 0;
};

struct Verdict {
    std::string violation;  // empty: none
    std::string schedule;   // the one that shows it
    uint64_t states = 0;
    uint64_t runs = 0;
    unsigned activations = 0;  // explored to the end with so many
    bool is_complete = false;  // more activations reach no new state
    bool has_passed() const { return violation.empty(); }
};

// Explores with `slots` slots. Breadth first, so that the schedule
// of a violation has the fewest activations.
Verdict explore(const Topology& topology, unsigned slots, const Limits& limits,
                const Start& start = {});

// Runs the one schedule that needs every slot: users below the highest publishing level start in
// increasing order of level and stay in their activations, with `depth` publications by the highest
// level between each two; then the highest level publishes once more.
Verdict run_constructed(const Topology& topology, unsigned slots);

}  // namespace stator::explorer
