// The true flight as a file: rows of 64-bit floats, 100 a second, least significant byte first.
//
// A row: time_us, position_N (3), velocity_N (3), q_NB (w x y z), rate_B (3), on_ground (0 or 1).
#pragma once

#include <cstdio>

#include "plant.hpp"

namespace stator::board {

inline constexpr std::uint64_t kTruthPeriod_us = 10000;
inline constexpr unsigned kTruthColumns = 15;

// False if the row could not be written whole.
[[nodiscard]] bool write_truth(std::FILE* file, const Plant& plant);

}  // namespace stator::board
