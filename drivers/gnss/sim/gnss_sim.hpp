// The satellite receiver of a simulated board: publishes the fix that the board received.
#pragma once

#include <array>
#include <cstdint>

#include "gnss_ports.hpp"

namespace stator::drivers::gnss::sim {

class GnssSim {
  public:
    // The newest fix. The board writes it, then raises received.
    struct Device {
        uint64_t timestamp_sample = 0;  // us, when it was true, not when it arrived
        double latitude_deg = 0.0;
        double longitude_deg = 0.0;
        double altitude_msl_m = 0.0;
        double altitude_ellipsoid_m = 0.0;
        std::array<float, 3> velocity_N{};  // m/s
        float horizontal_error = 0.0F;      // m, as the receiver believes
        float vertical_error = 0.0F;        // m
        float speed_error = 0.0F;           // m/s
        uint32_t satellites = 0;            // fewer than 4: no fix
    };

    explicit GnssSim(Device& device) : device_(device) {}
    void step(GnssPorts& ports);

  private:
    Device& device_;
};

}  // namespace stator::drivers::gnss::sim
