// What the generated graph connects to.
#pragma once

#include "button_test.hpp"

namespace stator::board {

extern ButtonTest::Device finger0;
extern ButtonTest::Device button0;

}  // namespace stator::board
