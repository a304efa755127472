// The vehicle of graph/quad.yaml, as the plant of emulated firmware has it.
#pragma once

#include "world/vehicle_text.hpp"
#include "world_vehicle.hpp"

namespace stator::world {

inline Vehicle iris() {
    return vehicle_of(board::kWorldVehicle);
}

}  // namespace stator::world
