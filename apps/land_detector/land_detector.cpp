// Landed or not.
#include "land_detector.hpp"

#include "stator/elapsed.hpp"
#include "stator/scalar.hpp"

namespace stator::apps::land_detector {

namespace {

constexpr float kLongestStep = 0.1F;
constexpr float kImpactCounts_s = 0.4F;  // a bounce comes to rest by then

bool knows_height(const LandDetectorPorts& ports) {
    return ports.position && ports.position->z_valid && ports.position->v_z_valid;
}

// As in a landing's last part. A setpoint that is not a number is free.
bool sinks_steadily(const TrajectorySetpoint& setpoint) {
    constexpr float kSteady = 0.05F;  // m/s^2
    const float acceleration = setpoint.acceleration[2];
    return setpoint.velocity[2] > 0.0F && !(math::abs(acceleration) > kSteady);
}

}  // namespace

bool LandDetector::has_touched_down(const LandDetectorPorts& ports, float dt) {
    const LandDetectorParams& params = *ports.params;
    since_impact_s_ = math::min(since_impact_s_ + dt, kImpactCounts_s);
    const bool known = knows_height(ports) && ports.setpoint && ports.thrust;
    if (!known || !sinks_steadily(*ports.setpoint)) {
        standing_for_s_ = still_for_s_ = 0.0F;
        return false;
    }
    if (ports.position->az < -params.impact) since_impact_s_ = 0.0F;
    const bool is_still = math::abs(ports.position->vz) < params.still;
    const bool is_light = -ports.thrust->xyz[2] < params.light_thrust;
    still_for_s_ = is_still ? still_for_s_ + dt : 0.0F;
    standing_for_s_ = is_still && is_light ? standing_for_s_ + dt : 0.0F;
    const bool hit = since_impact_s_ < kImpactCounts_s;
    return standing_for_s_ >= params.landed_after ||
           (hit && still_for_s_ >= params.landed_after_impact);
}

void LandDetector::update(const LandDetectorPorts& ports, float dt) {
    const bool armed =
        ports.status && ports.status->arming_state == VehicleStatus::ArmingState::kArmed;
    const bool begins = armed && !is_armed_;
    is_armed_ = armed;
    if (!armed || begins) has_landed_ = true;
    if ((!armed || begins) && knows_height(ports)) ground_z_ = ports.position->z;
    if (!armed) return;
    if (has_landed_) {
        const bool known = knows_height(ports);
        const float height = known ? ground_z_ - ports.position->z : 0.0F;
        const float speed = known ? math::abs(ports.position->vz) : 0.0F;
        has_landed_ = height < ports.params->takeoff_height && speed < ports.params->moving;
        standing_for_s_ = still_for_s_ = 0.0F;
        since_impact_s_ = kImpactCounts_s;
        return;
    }
    has_landed_ = has_touched_down(ports, dt);
    if (has_landed_) ground_z_ = ports.position->z;
}

void LandDetector::step(LandDetectorPorts& ports) {
    update(ports, seconds_since_last(last_us_, ports.now, 0.0F, kLongestStep));
    ports.land.publish([&] { return VehicleLandDetected{.landed = has_landed_}; });
}

}  // namespace stator::apps::land_detector
