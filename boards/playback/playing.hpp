// A recording of sensors behind the devices.
#pragma once

#include "recording.hpp"

namespace stator::board {

// Before the graph starts: what to replay. It must outlive the run.
void replay(const Recording& chosen);

}  // namespace stator::board
