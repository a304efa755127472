// Explores topologies named on the command line, or all of a kind.
//   explorer [options] ["1r 2w 3q" ...]
//   --depth 1,2,4   --levels 1,2,3,4   --shared   --activations 7   --most-states N   --fewer-slots
//   1
//   --first N       numbers samples after N    --full   begins with a full history
//   --burst N       each publisher that reads publishes so often; only topologies with such
//   --list          names each topology with its slots, without exploring
//   --constructed   runs the schedule that needs every slot, with the formula's and with one less
//   --expect-violation   succeeds if any topology fails: for broken variants of the code
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>

#include "search.hpp"

namespace {

using namespace stator::explorer;

struct Options {
    std::vector<unsigned> depths = {1, 2, 4};
    std::vector<unsigned> levels;
    std::vector<std::string> topologies;
    Limits limits;
    unsigned fewer_slots = 0;
    unsigned burst = 1;
    uint32_t first = 0;
    bool full = false;
    bool shared = false;
    bool list = false;
    bool constructed = false;
    bool expects_violation = false;
};

std::vector<unsigned> numbers(const char* text) {
    std::vector<unsigned> result;
    for (const char* at = text; at != nullptr; at = std::strchr(at, ',')) {
        if (*at == ',') ++at;
        result.push_back(static_cast<unsigned>(std::atoi(at)));
    }
    return result;
}

Options parse(int count, char** arguments) {
    Options options;
    for (int i = 1; i < count; ++i) {
        const std::string name = arguments[i];
        const auto value = [&] { return ++i < count ? arguments[i] : "0"; };
        if (name == "--depth")
            options.depths = numbers(value());
        else if (name == "--levels")
            options.levels = numbers(value());
        else if (name == "--activations")
            options.limits.activations = numbers(value())[0];
        else if (name == "--most-states")
            options.limits.states = numbers(value())[0];
        else if (name == "--fewer-slots")
            options.fewer_slots = numbers(value())[0];
        else if (name == "--burst")
            options.burst = numbers(value())[0];
        else if (name == "--first")
            options.first = static_cast<uint32_t>(std::atoll(value()));
        else if (name == "--full")
            options.full = true;
        else if (name == "--shared")
            options.shared = true;
        else if (name == "--list")
            options.list = true;
        else if (name == "--constructed")
            options.constructed = true;
        else if (name == "--expect-violation")
            options.expects_violation = true;
        else
            options.topologies.push_back(name);
    }
    return options;
}

std::vector<Topology> selected(const Options& options) {
    std::vector<Topology> all;
    for (const unsigned depth : options.depths) {
        for (const std::string& text : options.topologies) {
            all.push_back(parse_topology(text, depth));
        }
        for (const unsigned levels : options.levels) {
            const auto more = options.shared ? shared_level_topologies(levels, depth)
                                             : all_topologies(levels, depth);
            all.insert(all.end(), more.begin(), more.end());
        }
    }
    return options.burst > 1 ? with_burst(all, options.burst) : all;
}

bool show_constructed(const Topology& topology) {
    const unsigned slots = topology.slots();
    const Verdict enough = run_constructed(topology, slots);
    const Verdict fewer = run_constructed(topology, slots - 1);
    const bool is_tight = !fewer.has_passed();
    std::printf("%s: %u slots: %s, one less: %s\n", topology.name().c_str(), slots,
                enough.has_passed() ? "passes" : enough.violation.c_str(),
                is_tight ? fewer.violation.c_str() : "passes");
    return enough.has_passed() && is_tight;
}

bool show_explored(const Topology& topology, const Options& options) {
    const unsigned slots = topology.slots() - options.fewer_slots;
    const Verdict verdict = explore(topology, slots, options.limits,
                                    {options.first, options.full ? topology.depth : 0});
    std::printf("%s: %u slots, %u activations%s, %llu states, %llu runs%s%s\n",
                topology.name().c_str(), slots, verdict.activations,
                verdict.is_complete ? " and no new state after" : "",
                static_cast<unsigned long long>(verdict.states),
                static_cast<unsigned long long>(verdict.runs),
                verdict.has_passed() ? "" : (": " + verdict.violation).c_str(),
                verdict.has_passed() ? "" : ("\n    " + verdict.schedule).c_str());
    return verdict.has_passed();
}

}  // namespace

int main(int count, char** arguments) {
    const Options options = parse(count, arguments);
    unsigned failed = 0;
    const std::vector<Topology> all = selected(options);
    for (const Topology& topology : all) {
        if (options.list) {
            std::printf("%s: %u\n", topology.name().c_str(), topology.slots());
            continue;
        }
        failed +=
            options.constructed ? !show_constructed(topology) : !show_explored(topology, options);
        std::fflush(stdout);
    }
    std::printf("%zu topologies, %u failed\n", all.size(), failed);
    return (failed != 0) == options.expects_violation ? EXIT_SUCCESS : EXIT_FAILURE;
}
