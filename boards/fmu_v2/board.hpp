// What the generated graph connects to: the devices of this board that have a driver.
#pragma once

#include "drivers/can/bxcan/can_bxcan.hpp"
#include "drivers/system/board/system_board.hpp"

namespace stator::board {

extern drivers::can::bxcan::CanBxcan::Device can1;
extern drivers::system::board::SystemBoard::Device system0;

}  // namespace stator::board
