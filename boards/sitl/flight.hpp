// A simulated flight: the world that is behind the devices.
#pragma once

#include <cstdio>

#include "outside.hpp"
#include "world/world.hpp"

namespace stator::board {

// Before the graph starts: makes the world. `mission`, the memory of the mission device, and
// `truth`, which takes the true flight, may be null.
void prepare(const world::Conditions& conditions, const world::Vehicle& vehicle, std::FILE* mission,
             std::FILE* truth);

// The same, with the world of another simulator.
void prepare(Outside& other, std::FILE* mission);

const world::World& world();
bool is_over();
bool truth_is_whole();

}  // namespace stator::board
