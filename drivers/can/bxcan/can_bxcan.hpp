// The CAN controller of STM32F4 chips as a device of a graph.
#pragma once

#include <optional>

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

    explicit CanBxcan(Device& device) : device_(device) {}
    // The board fills the device in after this object was made, so the driver begins here.
    void step(CanPorts& ports) {
        if (!driver_) {
            driver_.emplace(
                BxcanPort<Memory>({device_.base}, bit_timing(device_.clock_hz, device_.bit_rate)));
        }
        driver_->step(ports);
    }

  private:
    Device& device_;
    std::optional<CanDriver<BxcanPort<Memory>>> driver_;
};

}  // namespace stator::drivers::can::bxcan
