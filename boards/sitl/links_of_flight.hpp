// The links between the machines of a graph, and machines that stop: docs/machines.md.
#pragma once

#include <cstdint>

#include "world/conditions.hpp"

namespace stator::board {

// False after one line that says what is wrong. Graphs of one machine have no links.
[[nodiscard]] bool prepare_links(const world::Conditions& conditions);
// When something happens on a link or to a machine.
std::uint64_t next_link_event_us();
// The next of these events.
void take_link_event();

}  // namespace stator::board
