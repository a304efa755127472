// A button that tests press.
#pragma once

#include "button_ports.hpp"

namespace stator::drivers::button::test {

class ButtonTest {
  public:
    struct Device {
        uint32_t served = 0;
        uint64_t last_now_us = 0;
    };

    explicit ButtonTest(Device& device) : device_(device) {}
    void step(ButtonPorts& ports) {
        if (!ports.fired.pressed) return;
        ++device_.served;
        device_.last_now_us = ports.now;
    }

  private:
    Device& device_;
};

}  // namespace stator::drivers::button::test
