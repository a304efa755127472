// What the generated graph connects to: the devices of this board that have a driver.
#pragma once

#include "can_bxcan.hpp"
#include "system_board.hpp"

namespace stator::board {

extern CanBxcan::Device can1;
extern SystemBoard::Device system0;

}  // namespace stator::board
