// What the generated graph connects to: the devices of this board that have a driver.
#pragma once

#include "can_bxcan.hpp"

namespace stator::board {

extern CanBxcan::Device can1;

}  // namespace stator::board
