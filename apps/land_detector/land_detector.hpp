// Finds out whether the vehicle stands on the ground.
#pragma once

#include <cstdint>

#include "land_detector_ports.hpp"

namespace stator::apps::land_detector {

// Runs with every estimate. It has landed while disarmed, and armed until it is above where it was
// armed, or moves up or down. In flight it has landed when for a while it is told to sink, does not
// sink, and thrust is too little to carry it: the ground does. After an impact it need only be
// still, and sooner: a vehicle that leans against the wind falls over if it goes on flying. Without
// a vertical speed it has never landed.
class LandDetector {
  public:
    void step(LandDetectorPorts& ports);

  private:
    bool has_touched_down(const LandDetectorPorts& ports, float dt);
    void update(const LandDetectorPorts& ports, float dt);

    bool is_armed_ = false;
    bool has_landed_ = true;
    float ground_z_ = 0.0F;
    float standing_for_s_ = 0.0F;
    float still_for_s_ = 0.0F;
    float since_impact_s_ = 0.0F;
    uint64_t last_us_ = 0;
};

}  // namespace stator::apps::land_detector
