// The CAN controller of STM32F4 chips as a device of a graph.
#pragma once

#include "bxcan_port.hpp"

namespace stator::drivers::can::bxcan {

class CanBxcan {
  public:
    // The board switches the controller's clock and pins on before the graph starts.
    struct Device {
        uintptr_t base;     // of its registers
        uint32_t clock_hz;  // of its bus
        uint32_t bit_rate;
    };

    explicit CanBxcan(Device& device)
        : driver_(BxcanPort<bxcan::Memory>({device.base},
                                           bxcan::bit_timing(device.clock_hz, device.bit_rate))) {}
    void step(CanPorts& ports) { driver_.step(ports); }

  private:
    CanDriver<BxcanPort<bxcan::Memory>> driver_;
};

}  // namespace stator::drivers::can::bxcan
