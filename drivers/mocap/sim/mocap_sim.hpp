// The motion capture of a simulated board: publishes what the board received.
#pragma once

#include <array>
#include <cstdint>

#include "mocap_ports.hpp"

namespace stator::drivers::mocap::sim {

class MocapSim {
  public:
    // The newest measurement received. The board writes it, then raises received.
    struct Device {
        uint64_t timestamp_sample = 0;      // us, of the picture, not of its arrival
        std::array<float, 3> position_N{};  // m
        float yaw = 0.0F;                   // rad
    };

    explicit MocapSim(Device& device) : device_(device) {}
    void step(MocapPorts& ports);

  private:
    Device& device_;
};

}  // namespace stator::drivers::mocap::sim
