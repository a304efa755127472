// What the generated graph connects to.
#pragma once

#include "button_test.hpp"
#include "stator/virtual.hpp"

namespace stator::board {

extern ButtonTest::Device finger0;
extern ButtonTest::Device button0;
extern Line button0_pressed;

}  // namespace stator::board
