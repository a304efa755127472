// The vehicle of a flight as text: a key and its numbers on each line. The compiler writes it from
// graph/vehicles/NAME.yaml, in SI units; `rotor` (x, y, z, 1 if counter-clockwise or -1, part of
// its thrust), `foot` and `hull` (x, y, z), `wheel`, `surface`, `stall_point` and `propeller` come
// once for each; the curves of a propeller follow it.
#pragma once

#include <string>
#include <string_view>

#include "world/variation.hpp"

namespace stator::world {

// Empty, or what is wrong.
[[nodiscard]] std::string read_vehicle(std::string_view text, Vehicle& vehicle);
// Of a text that the compiler wrote.
Vehicle vehicle_of(std::string_view text);

}  // namespace stator::world
