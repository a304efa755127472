// A satellite receiver whose fixes come from a recording.
#pragma once

#include <cstdint>

#include "gnss_ports.hpp"

namespace stator::drivers::gnss::recording {

class GnssRecording {
  public:
    // The newest fix of the recording. The board writes it, then raises received.
    struct Device {
        SensorGps fix;
    };

    explicit GnssRecording(Device& device) : device_(device) {}
    void step(GnssPorts& ports);

  private:
    Device& device_;
};

}  // namespace stator::drivers::gnss::recording
