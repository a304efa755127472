// One frame of the simulated radio receiver: from the world to the driver.
#pragma once

#include <cstdint>

namespace stator::drivers::radio::sim {

struct RadioSimSample {
    uint64_t timestamp_sample = 0;  // us
    float roll = 0.0F;              // sticks: -1 to 1
    float pitch = 0.0F;
    float yaw = 0.0F;
    float throttle = 0.0F;
    uint32_t mode_slot = 0;
    bool is_heard = false;
    bool arm = false;
    bool return_home = false;
    bool kill = false;
};

}  // namespace stator::drivers::radio::sim
