// The devices of a graph that is compiled, and whose nodes are tested one by one.
#pragma once

#include "can_bxcan.hpp"
#include "can_socketcan.hpp"
#include "stator/virtual.hpp"

namespace stator::board {

extern CanSocketcan::Device can1;
extern Line can1_received;
extern CanBxcan::Device can2;
extern Line can2_received;
extern Line can2_sent;
extern Line can2_changed;

}  // namespace stator::board
