// What becomes of the mission's memory: from the world to the driver.
#pragma once

namespace stator::drivers::mission::sim {

struct MissionSimSample {
    bool is_lost = false;
};

}  // namespace stator::drivers::mission::sim
