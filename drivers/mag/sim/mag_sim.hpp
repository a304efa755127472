// The magnetometer of a simulated board: publishes what the board measured.
#pragma once

#include <array>
#include <cstdint>

#include "mag_ports.hpp"

namespace stator::drivers::mag::sim {

class MagSim {
  public:
    // The newest sample. The board writes it, then raises data_ready.
    struct Device {
        uint64_t timestamp_sample = 0;  // us
        std::array<float, 3> field_B_gauss{};
    };

    explicit MagSim(Device& device) : device_(device) {}
    void step(MagPorts& ports);

  private:
    Device& device_;
};

}  // namespace stator::drivers::mag::sim
