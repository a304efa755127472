// A simulated flight: the world that is behind the devices.
#pragma once

#include <cstdio>

#include "messages/mission.hpp"
#include "world/world.hpp"

namespace stator::board {

// Before the graph starts: makes the world. It lies where the mission has its origin, if that has a
// place on Earth. `mission` and `truth`, which takes the true flight, may be null.
void prepare(world::Conditions conditions, const Mission* mission, std::FILE* truth);

const world::World& world();
bool truth_is_whole();

}  // namespace stator::board
