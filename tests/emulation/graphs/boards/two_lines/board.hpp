// What the generated graph connects to.
#pragma once

#include "switch_test.hpp"

namespace stator::board {

extern SwitchTest::Device switch0;
extern SwitchTest::Device switch1;

}  // namespace stator::board
