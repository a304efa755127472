// What the simulated battery says: from the world to the driver.
#pragma once

namespace stator::drivers::battery::sim {

struct BatterySimSample {
    float voltage_v = 0.0F;
    float current_a = 0.0F;
    float discharged_mah = 0.0F;
    float remaining = 0.0F;  // 1 to 0
};

}  // namespace stator::drivers::battery::sim
