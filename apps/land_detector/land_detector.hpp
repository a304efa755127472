// Finds out whether the vehicle stands on the ground.
#pragma once

#include <cstdint>

#include "crash.hpp"
#include "land_detector_ports.hpp"

namespace stator::apps::land_detector {

// Runs with every estimate. It has landed while disarmed, and armed until the thrust can carry it
// and it is above where it stood, or moves up or down: a drifting estimate is not a flight. In
// flight it has landed when for a while it does not sink, does not accelerate, and thrust is too
// little to carry it: the ground does. A setpoint that sinks makes that certain sooner. After an
// impact it need only be still, and sooner again: a vehicle that leans against the wind falls over
// if it goes on flying. Without a vertical speed, in descend, an impact and rest after it count.
class LandDetector {
  public:
    void step(LandDetectorPorts& ports);

  private:
    bool has_touched_down(const LandDetectorPorts& ports, float dt);
    bool is_carried(const LandDetectorPorts& ports, float dt);
    bool has_hit_the_ground(const LandDetectorPorts& ports, float dt);
    bool takes_off(const LandDetectorPorts& ports);
    void take_forces(const LandDetectorPorts& ports, float dt);
    void update(const LandDetectorPorts& ports, float dt);

    bool is_armed_ = false;
    bool has_landed_ = true;
    Crash crash_;
    bool has_crashed_ = false;
    float down_acceleration_ = 0.0F;  // low-passed
    float force_ = 9.80665F;          // specific, low-passed
    float ground_z_ = 0.0F;
    float standing_for_s_ = 0.0F;
    float resting_for_s_ = 0.0F;
    float still_for_s_ = 0.0F;
    float carried_for_s_ = 0.0F;
    float since_impact_s_ = 0.0F;
    float since_hit_s_ = 0.0F;
    float height_ = 0.0F;  // above the ground, when it was known last
    float blind_for_s_ = 0.0F;
    uint64_t last_us_ = 0;
};

}  // namespace stator::apps::land_detector
