// What a flight program says of the flight when it is over, as JSON; docs/json.md lists the keys.
#pragma once

#include <cstdio>

#include "world/world.hpp"

namespace stator::world {

// Prints `"ended": ..., "simulated_s": ...` and so on: members of an object that the caller opens
// and closes. `restarts`: that was the end of it.
void print_flight_facts(std::FILE* out, const World& world, double wall_s, bool restarts);

}  // namespace stator::world
