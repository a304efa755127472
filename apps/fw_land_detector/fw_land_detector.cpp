// An aeroplane on the ground or in the air.
#include "fw_land_detector.hpp"

#include "stator/elapsed.hpp"
#include "stator/rotation.hpp"

namespace stator::apps::fw_land_detector {

namespace {

constexpr float kGravity = 9.80665F;
constexpr float kLongestStep = 0.1F;
constexpr float kWeight = 1.5F;  // m/s^2, off gravity
constexpr float kQuiet = 0.1F;   // rad/s; a glide turns more
constexpr float kFallen = 0.5F;  // the cosine of 60 deg
constexpr float kCalm = 0.3F;    // rad/s

float counted(bool holds, float so_far, float dt) {
    return holds ? so_far + dt : 0.0F;
}

float thrust_of(const FwLandDetectorPorts& ports) {
    return ports.thrust ? ports.thrust->xyz[0] : 0.0F;
}

bool knows_speed(const FwLandDetectorPorts& ports) {
    return ports.position && ports.position->v_z_valid && ports.position->v_xy_valid;
}

float rate_of(const FwLandDetectorPorts& ports) {
    return ports.gyro ? math::norm(math::vector(ports.gyro->xyz)) : 0.0F;
}

}  // namespace

bool FwLandDetector::takes_off(const FwLandDetectorPorts& ports) {
    if (!knows_speed(ports)) return false;
    const VehicleLocalPosition& p = *ports.position;
    const FwLandDetectorParams& params = *ports.params;
    const bool pulls = thrust_of(ports) > params.pulls;
    if (!pulls) {
        ground_z_ = p.z;
        return false;
    }
    const bool is_above = p.z_valid && ground_z_ - p.z >= params.takeoff_height;
    const bool is_fast =
        ports.airspeed && ports.airspeed->calibrated_airspeed_m_s > params.takeoff_airspeed;
    return is_above || (is_fast && -p.vz > params.sinking);
}

bool FwLandDetector::has_stopped(const FwLandDetectorPorts& ports, float dt) {
    const FwLandDetectorParams& params = *ports.params;
    const bool pulls = thrust_of(ports) > params.pulls;
    if (knows_speed(ports)) {
        const VehicleLocalPosition& p = *ports.position;
        const float over_ground = math::sqrt(math::square(p.vx) + math::square(p.vy));
        const bool is_still = over_ground < params.still && math::abs(p.vz) < params.sinking;
        still_s_ = counted(is_still && !pulls, still_s_, dt);
        weighs_s_ = 0.0F;
        return still_s_ >= params.landed_after;
    }
    still_s_ = 0.0F;
    const float force = ports.accel ? math::norm(math::vector(ports.accel->xyz)) : 0.0F;
    const bool weighs = math::abs(force - kGravity) < kWeight && rate_of(ports) < kQuiet;
    const bool flies =
        ports.airspeed && ports.airspeed->calibrated_airspeed_m_s > params.takeoff_airspeed;
    weighs_s_ = counted(weighs && !pulls && !flies, weighs_s_, dt);
    return weighs_s_ >= params.blind_after;
}

bool FwLandDetector::lies(const FwLandDetectorPorts& ports, float dt) {
    if (!ports.attitude || !is_armed_) return false;
    const auto& q = ports.attitude->q;
    const float cos_tilt = 1.0F - 2.0F * (math::square(q[1]) + math::square(q[2]));
    const bool moves =
        knows_speed(ports) && math::norm(Eigen::Vector3f(ports.position->vx, ports.position->vy,
                                                         ports.position->vz)) > ports.params->still;
    const bool is_down = cos_tilt < kFallen && rate_of(ports) < kCalm && !moves;
    lies_s_ = counted(is_down, lies_s_, dt);
    return lies_s_ >= ports.params->crashed_after;
}

void FwLandDetector::step(FwLandDetectorPorts& ports) {
    const float dt = seconds_since_last(last_us_, ports.now, 0.0F, kLongestStep);
    const bool armed =
        ports.status && ports.status->arming_state == VehicleStatus::ArmingState::kArmed;
    const bool stands = !armed || !is_armed_;
    is_armed_ = armed;
    has_crashed_ = lies(ports, dt);
    if (stands) {
        has_landed_ = true;
        if (ports.position && ports.position->z_valid) ground_z_ = ports.position->z;
    } else if (has_landed_) {
        has_landed_ = !takes_off(ports);
        still_s_ = weighs_s_ = 0.0F;
    } else {
        has_landed_ = has_stopped(ports, dt);
    }
    ports.land.publish(
        [&] { return VehicleLandDetected{.landed = has_landed_, .crashed = has_crashed_}; });
}

}  // namespace stator::apps::fw_land_detector
