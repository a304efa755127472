// A barometer whose samples come from a recording.
#pragma once

#include <cstdint>

#include "baro_ports.hpp"

namespace stator::drivers::baro::recording {

class BaroRecording {
  public:
    // The newest sample of the recording, which the board writes.
    struct Device {
        uint64_t timestamp_sample = 0;  // us
        uint32_t samples = 0;           // since the start, to tell a new one
        float pressure = 0.0F;          // Pa
    };

    explicit BaroRecording(Device& device) : device_(device) {}
    void step(BaroPorts& ports);

  private:
    Device& device_;
    uint32_t published_ = 0;
};

}  // namespace stator::drivers::baro::recording
