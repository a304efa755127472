// What the generated graph connects to.
#pragma once

#include "drivers/button/test/button_test.hpp"

namespace stator::board {

extern drivers::button::test::ButtonTest::Device finger0;
extern drivers::button::test::ButtonTest::Device button0;

}  // namespace stator::board
