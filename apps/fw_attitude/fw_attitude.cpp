// Attitude control of an aeroplane.
#include "fw_attitude.hpp"

namespace stator::apps::fw_attitude {

using math::Vector3;

namespace {

constexpr float kGravity = 9.80665F;
// Towards 90 deg the turn of a bank grows without limit.
constexpr float kSteepest = 1.2F;  // rad
constexpr float kSlowest = 3.0F;   // m/s

bool is_usable(const VehicleAttitudeSetpoint& setpoint) {
    const auto& q = setpoint.q_d;
    const auto& thrust = setpoint.thrust_body;
    return math::is_finite(q[0] + q[1] + q[2] + q[3] + thrust[0] + thrust[1] + thrust[2] +
                           setpoint.yaw_sp_move_rate);
}

bool is_flown_by_hand(const FwAttitudePorts& ports) {
    using Nav = VehicleStatus::NavState;
    if (!ports.status || !ports.sticks || !ports.sticks->valid) return false;
    return ports.status->nav_state == Nav::kManual || ports.status->nav_state == Nav::kStabilized;
}

VehicleAttitudeSetpoint by_hand(const ManualControlSetpoint& sticks,
                                const FwAttitudeParams& params) {
    const auto q = math::from_euler(
        math::EulerAngles<float>{params.stick_roll * sticks.roll,
                                 params.level_pitch - params.stick_pitch * sticks.pitch, 0.0F});
    const float throttle = math::clamp(0.5F + 0.5F * sticks.throttle, 0.0F, 1.0F);
    return {
        .yaw_sp_move_rate = 0.0F, .q_d = math::to_array(q), .thrust_body = {throttle, 0.0F, 0.0F}};
}

float airspeed_of(const FwAttitudePorts& ports) {
    const FwAttitudeParams& params = *ports.params;
    const bool is_known = ports.airspeed && math::is_finite(ports.airspeed->true_airspeed_m_s);
    const float airspeed = is_known ? ports.airspeed->true_airspeed_m_s : params.trim_airspeed;
    return math::max(airspeed, math::max(params.stall_airspeed, kSlowest));
}

}  // namespace

Vector3<float> FwAttitude::rates(const FwAttitudePorts& ports) {
    const FwAttitudeParams& params = *ports.params;
    math::EulerAngles<float> wanted{0.0F, params.level_pitch, 0.0F};
    float ground_rate = 0.0F;
    VehicleAttitudeSetpoint setpoint{.q_d = {math::canonical_nan<float>()}};
    if (ports.setpoint) setpoint = *ports.setpoint;
    if (is_flown_by_hand(ports)) setpoint = by_hand(*ports.sticks, params);
    if (is_usable(setpoint)) {
        wanted = math::to_euler(math::quaternion(setpoint.q_d));
        ground_rate = setpoint.yaw_sp_move_rate;
        thrust_body_ = setpoint.thrust_body;
        has_setpoint_ = true;
    }
    if (!has_setpoint_) return Vector3<float>::Zero();

    const math::EulerAngles<float> is = math::to_euler(math::quaternion(ports.attitude->q));
    const float roll_rate = math::wrap_pi(wanted.roll - is.roll) / params.roll_time;
    const float pitch_rate = (wanted.pitch - is.pitch) / params.pitch_time;
    const math::SinCos<float> roll = math::sincos(is.roll);
    const math::SinCos<float> pitch = math::sincos(is.pitch);
    const float bank = math::clamp(is.roll, -kSteepest, kSteepest);
    float yaw_rate = kGravity * math::tan(bank) * pitch.cos / airspeed_of(ports);
    if (ground_rate != 0.0F) yaw_rate = ground_rate;
    const Vector3<float> rates(roll_rate - pitch.sin * yaw_rate,
                               roll.cos * pitch_rate + roll.sin * pitch.cos * yaw_rate,
                               roll.cos * pitch.cos * yaw_rate - roll.sin * pitch_rate);
    const Vector3<float> limit(params.roll_rate_limit, params.pitch_rate_limit,
                               params.yaw_rate_limit);
    return rates.cwiseMin(limit).cwiseMax(-limit);
}

void FwAttitude::step(FwAttitudePorts& ports) {
    if (!ports.attitude) return;
    const Vector3<float> rates = this->rates(ports);
    ports.rates.publish([&] {
        return VehicleRatesSetpoint{
            .roll = rates.x(), .pitch = rates.y(), .yaw = rates.z(), .thrust_body = thrust_body_};
    });
}

}  // namespace stator::apps::fw_attitude
