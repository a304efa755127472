// The devices of a graph that is compiled, and whose nodes are tested one by one.
#pragma once

#include "drivers/can/bxcan/can_bxcan.hpp"
#include "drivers/can/socketcan/can_socketcan.hpp"
#include "stator/virtual.hpp"

namespace stator::board {

extern drivers::can::socketcan::CanSocketcan::Device can1;
extern Line can1_received;
extern drivers::can::bxcan::CanBxcan::Device can2;
extern Line can2_received;
extern Line can2_sent;
extern Line can2_changed;

}  // namespace stator::board
