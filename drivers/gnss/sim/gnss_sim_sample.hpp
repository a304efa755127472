// One fix of the simulated satellite receiver: from the world to the driver.
#pragma once

#include <array>
#include <cstdint>

namespace stator::drivers::gnss::sim {

struct GnssSimSample {
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

}  // namespace stator::drivers::gnss::sim
