// The barometer of a simulated board: publishes each sample that the board measured once.
#pragma once

#include <cstdint>

#include "baro_ports.hpp"

namespace stator::drivers::baro::sim {

class BaroSim {
  public:
    // The newest sample, which the board writes.
    struct Device {
        uint64_t timestamp_sample = 0;  // us
        uint32_t samples = 0;           // since the start, to tell a new one; wraps
        float pressure = 0.0F;          // Pa
        float temperature_degc = 0.0F;
        // Brings this up to date, where the board writes in another thread; else none.
        void (*refresh)(Device&) = nullptr;
    };

    explicit BaroSim(Device& device) : device_(device) {}
    void step(BaroPorts& ports);

  private:
    Device& device_;
    uint32_t published_ = 0;
};

}  // namespace stator::drivers::baro::sim
