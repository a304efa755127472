// What the chip says about itself: RM0090, 38.6.1, 39.1, 39.2. Revision 3 of an STM32F427 with 2
// MB.
#pragma once

#include "chip/block.hpp"

namespace stator::chip {

class DeviceId : public Block {
  public:
    explicit DeviceId(Chip& chip);
};

class Debug : public Block {
  public:
    explicit Debug(Chip& chip);
};

}  // namespace stator::chip
