// What the simulated range finder says: from the world to the driver.
#pragma once

namespace stator::drivers::polled_range::sim {

struct PolledRangeSimSample {
    float distance = 0.0F;  // m
};

}  // namespace stator::drivers::polled_range::sim
