// A port of 16 pins: RM0090, chapter 8.
#pragma once

#include "chip/block.hpp"
#include "chip/exti.hpp"

namespace stator::chip {

class Gpio : public Block {
  public:
    Gpio(Chip& chip, char port, Exti& exti);
    void reset() override;

  private:
    uint32_t on_read(uint32_t offset) override;
    void on_write(uint32_t offset, uint32_t value) override;
    void drive();
    unsigned mode(unsigned number) const;

    char port_;
    unsigned first_;  // pin
};

}  // namespace stator::chip
