// One sample of the simulated pitot tube: from the world to the driver.
#pragma once

#include <cstdint>
#include <span>

namespace stator::drivers::airspeed::sim {

struct AirspeedSimSample {
    uint64_t timestamp_sample = 0;  // us
    float pressure = 0.0F;          // Pa, total less static
    float temperature_degc = 0.0F;

    // For faults.
    template <class Visit>
    void each_quantity(Visit&& visit) {
        visit("pressure", std::span<float>(&pressure, 1));
    }
};

}  // namespace stator::drivers::airspeed::sim
