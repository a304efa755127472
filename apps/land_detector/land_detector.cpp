// Landed or not.
#include "land_detector.hpp"

#include "stator/elapsed.hpp"
#include "stator/scalar.hpp"

namespace stator::apps::land_detector {

namespace {

constexpr float kGravity = 9.80665F;
constexpr float kLongestStep = 0.1F;
constexpr float kImpactCounts_s = 0.4F;  // a bounce comes to rest by then
constexpr float kSmoothing_s = 0.1F;     // of accelerations
// Thrust of this part of `light_thrust` makes any vehicle fall faster than kSteady.
constexpr float kVeryLight = 0.7F;
constexpr float kSteady = 1.5F;  // m/s^2
// A vehicle that falls accelerates; one whose estimate drifts does not.
constexpr float kFalling = 2.0F;  // m/s^2
// Blind: an impact counts for longer, and then everything must be quiet.
constexpr float kHitCounts_s = 5.0F;
constexpr float kFastestBlind = 3.0F;  // m/s
constexpr float kHigh = 6.0F;          // m, more than a height is off by
constexpr float kQuiet_s = 0.5F;
constexpr float kQuietRate = 0.3F;  // rad/s
constexpr float kCarried = 0.4F;    // of the weight
constexpr float kCarried_s = 5.0F;

bool knows_height(const LandDetectorPorts& ports) {
    return ports.position && ports.position->z_valid && ports.position->v_z_valid;
}

bool knows_speed(const LandDetectorPorts& ports) {
    return ports.position && ports.position->v_z_valid;
}

float thrust_of(const LandDetectorPorts& ports) {
    return ports.thrust ? -ports.thrust->xyz[2] : 0.0F;
}

// As in a landing's last part. A setpoint that is not a number is free.
bool sinks_steadily(const LandDetectorPorts& ports) {
    constexpr float kSteadySetpoint = 0.05F;  // m/s^2
    if (!ports.setpoint) return false;
    const float acceleration = ports.setpoint->acceleration[2];
    return ports.setpoint->velocity[2] > 0.0F && !(math::abs(acceleration) > kSteadySetpoint);
}

bool descends(const LandDetectorPorts& ports) {
    return ports.status && ports.status->nav_state == VehicleStatus::NavState::kDescend;
}

float counted(bool holds, float so_far, float dt) {
    return holds ? so_far + dt : 0.0F;
}

}  // namespace

void LandDetector::take_forces(const LandDetectorPorts& ports, float dt) {
    const float blend = dt / (kSmoothing_s + dt);
    if (ports.position && math::is_finite(ports.position->az))
        down_acceleration_ += blend * (ports.position->az - down_acceleration_);
    has_crashed_ = false;
    if (!ports.accel || !ports.gyro || !ports.attitude) return;
    const auto force_B = math::vector(ports.accel->xyz);
    const auto rate_B = math::vector(ports.gyro->xyz);
    const auto& q = ports.attitude->q;
    const float cos_tilt = 1.0F - 2.0F * (math::square(q[1]) + math::square(q[2]));
    if (!math::is_finite(force_B.sum() + rate_B.sum() + cos_tilt)) return;
    force_ += blend * (math::norm(force_B) - force_);
    has_crashed_ = crash_.update(force_B, rate_B, cos_tilt, dt) && is_armed_;
}

bool LandDetector::has_touched_down(const LandDetectorPorts& ports, float dt) {
    const LandDetectorParams& params = *ports.params;
    since_impact_s_ = math::min(since_impact_s_ + dt, kImpactCounts_s);
    if (is_carried(ports, dt)) return true;
    if (!knows_speed(ports) || !ports.thrust) {
        standing_for_s_ = resting_for_s_ = 0.0F;
        return has_hit_the_ground(ports, dt);
    }
    since_hit_s_ = kHitCounts_s;
    blind_for_s_ = 0.0F;
    if (ports.position->z_valid) height_ = ground_z_ - ports.position->z;
    const bool sinks = sinks_steadily(ports);
    if (sinks && ports.position->az < -params.impact) since_impact_s_ = 0.0F;
    const bool is_still = math::abs(ports.position->vz) < params.still;
    const bool is_steady = math::abs(down_acceleration_) < kSteady;
    const float thrust = thrust_of(ports);
    still_for_s_ = counted(sinks && is_still, still_for_s_, dt);
    standing_for_s_ =
        counted(sinks && is_still && thrust < params.light_thrust, standing_for_s_, dt);
    resting_for_s_ = counted(is_still && is_steady && thrust < kVeryLight * params.light_thrust,
                             resting_for_s_, dt);
    // A jolt high up is a gust.
    const bool is_high = ports.position->z_valid && height_ > kHigh;
    const bool hit = since_impact_s_ < kImpactCounts_s && !is_high;
    return standing_for_s_ >= params.landed_after ||
           resting_for_s_ >= params.landed_unasked_after ||
           (hit && still_for_s_ >= params.landed_after_impact);
}

// Whatever the estimate says: what feels its weight without thrust, and does not turn, is carried.
bool LandDetector::is_carried(const LandDetectorPorts& ports, float dt) {
    if (!ports.thrust || !ports.accel || !ports.gyro) return false;
    const bool is_light = thrust_of(ports) < kVeryLight * ports.params->light_thrust;
    const bool has_weight = math::abs(force_ - kGravity) < kCarried * kGravity;
    const bool turns = math::norm(math::vector(ports.gyro->xyz)) > kQuietRate;
    carried_for_s_ = counted(is_light && has_weight && !turns, carried_for_s_, dt);
    return carried_for_s_ >= kCarried_s;
}

// Where no vertical speed is known.
bool LandDetector::has_hit_the_ground(const LandDetectorPorts& ports, float dt) {
    since_hit_s_ = math::min(since_hit_s_ + dt, kHitCounts_s);
    blind_for_s_ += dt;
    const bool is_high =
        ports.position && ports.position->z_valid && ground_z_ - ports.position->z > kHigh;
    const bool may_be_down = kFastestBlind * blind_for_s_ > height_ && !is_high;
    if (!descends(ports) || !may_be_down || !ports.accel || !ports.gyro) return false;
    // A jolt: one that leans far feels more than its weight, but steadily.
    const float force = math::norm(math::vector(ports.accel->xyz));
    if (force - force_ > ports.params->impact) since_hit_s_ = 0.0F;
    const bool is_quiet = math::abs(force_ - kGravity) < kSteady &&
                          math::norm(math::vector(ports.gyro->xyz)) < kQuietRate;
    still_for_s_ = counted(is_quiet && since_hit_s_ < kHitCounts_s, still_for_s_, dt);
    return still_for_s_ >= kQuiet_s;
}

bool LandDetector::takes_off(const LandDetectorPorts& ports) {
    if (!knows_speed(ports)) return false;
    const VehicleLocalPosition& p = *ports.position;
    const LandDetectorParams& params = *ports.params;
    const bool carries = !ports.thrust || thrust_of(ports) >= params.light_thrust;
    const bool falls = p.vz > params.moving && p.az > kFalling;
    if (!carries) {
        ground_z_ = p.z;
        return falls;
    }
    const bool rises = p.z_valid && ground_z_ - p.z >= params.takeoff_height;
    return rises || math::abs(p.vz) >= params.moving;
}

void LandDetector::update(const LandDetectorPorts& ports, float dt) {
    const bool armed =
        ports.status && ports.status->arming_state == VehicleStatus::ArmingState::kArmed;
    const bool begins = armed && !is_armed_;
    is_armed_ = armed;
    take_forces(ports, dt);
    if (!armed || begins) has_landed_ = true;
    if ((!armed || begins) && knows_height(ports)) ground_z_ = ports.position->z;
    if (!armed) {
        crash_.reset();
        return;
    }
    if (has_landed_) {
        has_landed_ = !takes_off(ports);
        standing_for_s_ = resting_for_s_ = still_for_s_ = carried_for_s_ = 0.0F;
        since_impact_s_ = kImpactCounts_s;
        since_hit_s_ = kHitCounts_s;
        return;
    }
    has_landed_ = has_touched_down(ports, dt);
    if (has_landed_ && knows_height(ports)) ground_z_ = ports.position->z;
}

void LandDetector::step(LandDetectorPorts& ports) {
    update(ports, seconds_since_last(last_us_, ports.now, 0.0F, kLongestStep));
    ports.land.publish(
        [&] { return VehicleLandDetected{.landed = has_landed_, .crashed = has_crashed_}; });
}

}  // namespace stator::apps::land_detector
