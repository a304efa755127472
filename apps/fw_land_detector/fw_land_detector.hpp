// Finds out whether an aeroplane stands on the ground.
#pragma once

#include <cstdint>

#include "fw_land_detector_ports.hpp"

namespace stator::apps::fw_land_detector {

// Runs with every estimate. It has landed while disarmed, and armed until it is above where it
// stood or climbs with the airspeed that carries it. In flight it has landed when it has moved
// neither over ground nor up or down for a while, without thrust: in a wind as strong as the
// airspeed it may stand over a place, but not without thrust. Without a speed, it has when it feels
// its weight and does not turn.
class FwLandDetector {
  public:
    void step(FwLandDetectorPorts& ports);

  private:
    bool takes_off(const FwLandDetectorPorts& ports);
    bool has_stopped(const FwLandDetectorPorts& ports, float dt);
    bool lies(const FwLandDetectorPorts& ports, float dt);

    bool is_armed_ = false;
    bool has_landed_ = true;
    bool has_crashed_ = false;
    float ground_z_ = 0.0F;
    float still_s_ = 0.0F;
    float weighs_s_ = 0.0F;
    float lies_s_ = 0.0F;
    uint64_t last_us_ = 0;
};

}  // namespace stator::apps::fw_land_detector
