// The true flight as a file: a line of text that names the columns, then rows of 64-bit floats, 100
// a second, least significant byte first. The line is filled with blanks to a multiple of 8 bytes.
#pragma once

#include <array>
#include <cstdio>

#include "world/world.hpp"

namespace stator::world {

inline constexpr std::uint64_t kTruthPeriod_us = 10000;
// N is north-east-down, B forward-right-down; SI units, the rest is in the name.
// Then the speed of each rotor, rotor_1 and so on, of each propeller, propeller_1, the deflection
// of each surface, surface_1, and the battery.
inline constexpr std::array kTruthColumns{
    "time_us",    "position_n", "position_e", "position_d", "velocity_n", "velocity_e",
    "velocity_d", "q_w",        "q_x",        "q_y",        "q_z",        "rate_x",
    "rate_y",     "rate_z",     "on_ground",  "wind_n",     "wind_e",     "wind_d"};
inline constexpr std::array kBatteryColumns{"voltage_v", "current_a", "remaining"};

// Both are false if not all could be written.
[[nodiscard]] bool write_truth_head(std::FILE* file, const World& world);
[[nodiscard]] bool write_truth(std::FILE* file, const World& world);

}  // namespace stator::world
