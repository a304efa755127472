// Height, airspeed and bank of an aeroplane.
#include "tecs.hpp"

#include "stator/elapsed.hpp"

namespace stator::apps::tecs {

using math::Vector3;

namespace {

constexpr float kNaN = math::canonical_nan<float>();
constexpr float kGravity = 9.80665F;
constexpr float kShortestStep = 1e-3F;
constexpr float kLongestStep = 0.1F;
constexpr float kSlow = 3.0F;        // m/s: slower air has no direction
constexpr float kLeastBank = 0.17F;  // rad
constexpr float kCarries = 1.15F;    // of the stall airspeed

bool is_armed(const TecsPorts& ports) {
    return ports.status && ports.status->arming_state == VehicleStatus::ArmingState::kArmed;
}

// Along the way through the air.
float airspeed_rate(const TecsPorts& ports) {
    const VehicleLocalPosition& p = *ports.position;
    Vector3<float> air_N(p.vx, p.vy, p.vz);
    if (ports.wind && ports.wind->valid) {
        air_N -= Vector3<float>(ports.wind->windspeed_north, ports.wind->windspeed_east, 0.0F);
    }
    const float speed = math::norm(air_N);
    const float rate = speed > kSlow ? Vector3<float>(p.ax, p.ay, p.az).dot(air_N) / speed : 0.0F;
    return math::is_finite(rate) ? rate : 0.0F;
}

}  // namespace

Motion Tecs::motion_of(const TecsPorts& ports) const {
    const VehicleLocalPosition& p = *ports.position;
    float airspeed = kNaN;
    float tas_over_eas = 1.0F;
    if (ports.airspeed) {
        airspeed = ports.airspeed->true_airspeed_m_s;
        const float ratio = airspeed / ports.airspeed->calibrated_airspeed_m_s;
        if (ratio > 0.5F && ratio < 2.0F) tas_over_eas = ratio;
    }
    const math::EulerAngles<float> angles = math::to_euler(math::quaternion(ports.attitude->q));
    const float cos_roll = math::max(math::cos(angles.roll), 0.3F);
    return {.height = p.z_valid ? -p.z : kNaN,
            .height_rate = p.v_z_valid && math::is_finite(p.vz) ? -p.vz : 0.0F,
            .airspeed = airspeed,
            .airspeed_rate = airspeed_rate(ports),
            .load_factor = 1.0F / cos_roll,
            .tas_over_eas = tas_over_eas,
            .pitch = angles.pitch};
}

float Tecs::roll_for(const TecsPorts& ports, const Motion& motion, float dt) {
    const TecsParams& params = *ports.params;
    float wanted = 0.0F;
    if (ports.lateral && math::is_finite(ports.lateral->lateral_acceleration)) {
        wanted = math::atan(ports.lateral->lateral_acceleration / kGravity);
    }
    float limit = params.roll_limit;
    if (math::is_finite(motion.airspeed)) {
        const float stall = kCarries * motion.tas_over_eas * params.stall_airspeed;
        const float load = math::square(motion.airspeed / math::max(stall, 1.0F));
        const float carried = load > 1.0F ? math::acos(1.0F / load) : 0.0F;
        limit = math::min(limit, math::max(carried, kLeastBank));
    }
    const float most = params.roll_slew * dt;
    roll_ += math::clamp(math::clamp(wanted, -limit, limit) - roll_, -most, most);
    return roll_;
}

void Tecs::step(TecsPorts& ports) {
    if (!ports.position || !ports.attitude) return;
    const float dt = seconds_since_last(last_us_, ports.now, kShortestStep, kLongestStep);
    const Motion motion = motion_of(ports);
    Wanted wanted{
        .height = kNaN, .height_rate = 0.0F, .airspeed = kNaN, .pitch = kNaN, .throttle = kNaN};
    if (ports.longitudinal) {
        const FixedWingLongitudinalSetpoint& setpoint = *ports.longitudinal;
        wanted = {.height = setpoint.altitude,
                  .height_rate = setpoint.height_rate,
                  .airspeed = setpoint.equivalent_airspeed * motion.tas_over_eas,
                  .pitch = setpoint.pitch_direct,
                  .throttle = setpoint.throttle_direct};
    }
    if (!math::is_finite(motion.height) && math::is_finite(wanted.height)) wanted.height = kNaN;
    float roll = 0.0F;
    if (is_armed(ports)) {
        roll = roll_for(ports, motion, dt);
        energy_.update(motion, wanted, *ports.params, dt);
    } else {
        roll_ = 0.0F;
        energy_.reset();
    }
    const bool on_ground = ports.lateral && math::is_finite(ports.lateral->yaw_rate);
    const float throttle = is_armed(ports) ? energy_.throttle() : 0.0F;
    const float pitch = is_armed(ports) ? energy_.pitch() : motion.pitch;
    const float heading = math::heading(math::quaternion(ports.attitude->q));
    ports.tecs.publish([&] { return energy_.status(); });
    ports.attitude_setpoint.publish([&] {
        return VehicleAttitudeSetpoint{
            .yaw_sp_move_rate = on_ground ? ports.lateral->yaw_rate : 0.0F,
            .q_d = math::to_array(math::from_euler(math::EulerAngles<float>{roll, pitch, heading})),
            .thrust_body = {throttle, 0.0F, 0.0F}};
    });
}

}  // namespace stator::apps::tecs
