// Lines from pins to interrupts: RM0090, chapters 9 and 12.
#pragma once

#include "chip/block.hpp"

namespace stator::chip {

class SystemConfiguration : public Block {
  public:
    explicit SystemConfiguration(Chip& chip);
    // The port whose pin is on the line, 0 for A.
    unsigned port_of(unsigned line) const;
};

class Exti : public Block {
  public:
    Exti(Chip& chip, const SystemConfiguration& configuration);
    // An edge of a pin, numbered as in pins.hpp.
    void edge(unsigned pin, bool is_rising);

  private:
    void on_write(uint32_t offset, uint32_t value) override;
    void update();
    const SystemConfiguration& configuration_;
};

}  // namespace stator::chip
