// The links between the machines of a graph, and machines that stop.
#include "links_of_flight.hpp"

#if __has_include("links.hpp")

#include <algorithm>
#include <array>
#include <cstdio>
#include <memory>
#include <string_view>
#include <vector>

#include "links.hpp"
#include "stator/virtual.hpp"
#include "world/wire.hpp"

namespace stator::board {

namespace {

using world::Fault;
using world::FaultKind;
using world::Wire;

constexpr std::string_view kPart = "link";          // all links together
constexpr std::uint64_t kFirstStream = 0x4C494E4B;  // of random numbers: a range of its own

struct Link;
// What a frame of an end needs.
struct Place {
    Link* link = nullptr;
    unsigned end = 0;
    std::uint32_t boot = 1;
};
struct Link {
    const LinkOfGraph* of_graph;
    Wire wire;
    std::array<Place, Wire::kEnds> places{};

    const LinkEnd& end(unsigned i) const { return i == 0 ? of_graph->near : of_graph->far; }
};
std::vector<Link> links;
std::vector<Fault> faults;
// When a fault begins or ends.
std::vector<std::uint64_t> changes;
std::size_t next_change = 0;

void start_frame(void* wire, std::span<const std::uint8_t> frame) {
    auto* const place = static_cast<Place*>(wire);
    place->link->wire.send(place->end, frame, executor.now_us);
}

bool is_down(std::string_view machine, std::uint64_t now_us) {
    return std::any_of(faults.begin(), faults.end(), [&](const Fault& fault) {
        return fault.kind == FaultKind::kKill && fault.is_of(machine) && fault.acts(now_us);
    });
}

// The ends of a machine lose what they had; a machine that starts has another number.
void reset(std::string_view machine) {
    for (Link& link : links) {
        if (machine != link.of_graph->name) continue;
        Place& place = link.places[0];
        machines::End* const end = link.end(0).end;
        link.wire.stop(0);
        std::destroy_at(end);
        std::construct_at(end);
        end->connect(&place, start_frame, ++place.boot);
    }
}

void change(std::uint64_t now_us) {
    double noise = 0.0;
    bool is_cut = false;
    for (const Fault& fault : faults) {
        if (fault.kind == FaultKind::kKill && (fault.from_us == now_us || fault.until_us == now_us))
            reset(fault.part.data());
        if (fault.kind == FaultKind::kKill && fault.until_us == now_us) {
            for (const TaskOfMachine& row : kTasksOfMachines)
                if (fault.is_of(row.machine)) row.restart();
        }
        if (!fault.is_of(kPart) || !fault.acts(now_us)) continue;
        is_cut = is_cut || fault.kind == FaultKind::kCut;
        if (fault.kind == FaultKind::kNoise) noise = fault.value;
    }
    for (Link& link : links) link.wire.set_faults(is_cut, noise);
}

[[nodiscard]] bool silence_machine(const Fault& fault) {
    bool is_known = false;
    for (const TaskOfMachine& row : kTasksOfMachines) {
        if (!fault.is_of(row.machine)) continue;
        is_known = silence(row.task, fault.from_us, fault.until_us, false);
    }
    if (!is_known) {
        std::fprintf(stderr, "error: --fail: unknown machine '%s'\n", fault.part.data());
    }
    return is_known;
}

}  // namespace

bool prepare_links(const world::Conditions& conditions) {
    for (const LinkOfGraph& row : kLinks) {
        const std::uint64_t stream = kFirstStream + links.size();
        links.push_back(
            {&row, Wire(row.baud, {row.wake_up_us, 0}, math::Random(conditions.seed, stream))});
    }
    for (Link& link : links) {
        for (unsigned i = 0; i < Wire::kEnds; ++i) {
            link.places[i] = {&link, i};
            link.end(i).end->connect(&link.places[i], start_frame, link.places[i].boot);
        }
    }
    for (const Fault& fault : conditions.faults) {
        const bool is_of_machine =
            fault.kind == FaultKind::kKill || fault.kind == FaultKind::kFreeze;
        if (is_of_machine && !silence_machine(fault)) return false;
        if (!is_of_machine && !fault.is_of(kPart)) continue;
        faults.push_back(fault);
        changes.insert(changes.end(), {fault.from_us, fault.until_us});
    }
    std::sort(changes.begin(), changes.end());
    return true;
}

std::uint64_t next_link_event_us() {
    std::uint64_t next = next_change < changes.size() ? changes[next_change] : Wire::kNever;
    for (const Link& link : links) next = std::min(next, link.wire.next_event_us());
    return next;
}

void take_link_event() {
    const std::uint64_t now_us = next_link_event_us();
    if (next_change < changes.size() && changes[next_change] == now_us) {
        while (next_change < changes.size() && changes[next_change] == now_us) ++next_change;
        change(now_us);
        return;
    }
    for (Link& link : links) {
        if (link.wire.next_event_us() != now_us) continue;
        const Wire::Event event = link.wire.take();
        const LinkEnd& end = link.end(event.end);
        if (event.end == 0 && is_down(link.of_graph->name, now_us)) return;
        if (event.kind == Wire::Event::Kind::kSent) {
            end.end->finish();
            end.sent->raise();
        } else {
            end.end->put(event.bytes);
            end.received->raise();
        }
        return;
    }
}

}  // namespace stator::board

#else

namespace stator::board {

bool prepare_links(const world::Conditions& /*conditions*/) {
    return true;
}
std::uint64_t next_link_event_us() {
    return UINT64_MAX;
}
void take_link_event() {}

}  // namespace stator::board

#endif
