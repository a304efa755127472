// A recording of sensors behind the devices.
#pragma once

#include "recording.hpp"

namespace stator::board {

// Before the graph starts: what to play. It must outlive the run.
void play(const Recording& chosen);

}  // namespace stator::board
