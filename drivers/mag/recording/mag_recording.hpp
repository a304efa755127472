// A magnetometer whose samples come from a recording.
#pragma once

#include <array>
#include <cstdint>

#include "mag_ports.hpp"

namespace stator::drivers::mag::recording {

class MagRecording {
  public:
    // The sample that is current in the recording. The board writes it, then raises data_ready.
    struct Device {
        uint64_t timestamp_sample = 0;   // us
        std::array<float, 3> field_B{};  // gauss
    };

    explicit MagRecording(Device& device) : device_(device) {}
    void step(MagPorts& ports);

  private:
    Device& device_;
};

}  // namespace stator::drivers::mag::recording
