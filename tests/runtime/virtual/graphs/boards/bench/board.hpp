// A button on virtual time.
#pragma once

#include "drivers/button/test/button_test.hpp"
#include "stator/virtual.hpp"

namespace stator::board {

extern drivers::button::test::ButtonTest::Device button0;
extern Line button0_pressed;

}  // namespace stator::board
