// What the simulated battery says: from the world to the driver.
#pragma once

#include <span>

namespace stator::drivers::battery::sim {

struct BatterySimSample {
    float voltage_v = 0.0F;
    float current_a = 0.0F;
    float discharged_mah = 0.0F;
    float remaining = 0.0F;  // 1 to 0

    // For faults.
    template <class Visit>
    void each_quantity(Visit&& visit) {
        visit("remaining", std::span<float>(&remaining, 1));
        visit("voltage", std::span<float>(&voltage_v, 1));
    }
};

}  // namespace stator::drivers::battery::sim
