// One sample of the simulated barometer: from the world to the driver.
#pragma once

#include <cstdint>

namespace stator::drivers::baro::sim {

struct BaroSimSample {
    uint64_t timestamp_sample = 0;  // us
    float pressure = 0.0F;          // Pa
    float temperature_degc = 0.0F;
};

}  // namespace stator::drivers::baro::sim
