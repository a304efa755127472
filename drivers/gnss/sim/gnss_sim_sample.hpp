// One fix of the simulated satellite receiver: from the world to the driver.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "stator/scalar.hpp"

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

    // For faults: the velocity, and the position in metres north, east, down from where it is.
    template <class Visit>
    void each_quantity(Visit&& visit) {
        constexpr double kMetresPerDegree = 111'320.0;
        constexpr double kDegree = math::kPi<double> / 180.0;
        std::array<double, 3> shift{};
        visit("velocity", std::span<float>(velocity_N));
        visit("position", std::span<double>(shift));
        latitude_deg += shift[0] / kMetresPerDegree;
        longitude_deg += shift[1] / (kMetresPerDegree * math::sincos(kDegree * latitude_deg).cos);
        altitude_msl_m -= shift[2];
    }
};

}  // namespace stator::drivers::gnss::sim
