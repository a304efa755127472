// What decides a simulated flight besides the graph. By default all is well, and calm.
#pragma once

#include <cstdint>

#include "world/earth.hpp"
#include "world/faults.hpp"
#include "world/launch.hpp"
#include "world/pilot.hpp"
#include "world/wind.hpp"

namespace stator::world {

struct Conditions {
    std::uint64_t seed = 1;  // of the start, the sensors' biases and all noise
    bool vary = false;       // the vehicle, from the seed
    Launch launch = Launch::kGround;
    WindParameters wind{};
    Faults faults{};
    Pilot pilot{};
    Earth earth{};
    bool is_endless = false;  // goes on when the motors stand still: others end it
};

}  // namespace stator::world
