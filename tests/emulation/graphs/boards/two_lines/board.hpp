// What the generated graph connects to.
#pragma once

#include "drivers/contact/test/contact_test.hpp"

namespace stator::board {

extern drivers::contact::test::ContactTest::Device switch0;
extern drivers::contact::test::ContactTest::Device switch1;

}  // namespace stator::board
