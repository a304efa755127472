// What decides a simulated flight besides the graph. By default all is well, and calm.
#pragma once

#include <cstdint>

#include "earth.hpp"
#include "faults.hpp"
#include "pilot.hpp"
#include "wind.hpp"

namespace stator::board {

struct Conditions {
    std::uint64_t seed = 1;  // of the start, the sensors' biases and all noise
    bool vary = false;       // the vehicle, from the seed
    WindParameters wind{};
    Faults faults{};
    Pilot pilot{};
    Earth earth{};
};

}  // namespace stator::board
