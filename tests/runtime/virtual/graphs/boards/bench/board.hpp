// A button on virtual time.
#pragma once

#include "button_test.hpp"
#include "stator/virtual.hpp"

namespace stator::board {

extern ButtonTest::Device button0;
extern Line button0_pressed;

}  // namespace stator::board
