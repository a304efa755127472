// Attitude control: from an attitude setpoint to a body-rate setpoint.
#include "attitude_control.hpp"

namespace stator::apps::attitude_control {

using math::Quaternion;
using math::Vector3;

namespace {

// Below this the thrust axis points the opposite way, and no heading is nearer than another.
constexpr float kHeadingUndefined = 1e-6F;

bool is_usable(const VehicleAttitudeSetpoint& setpoint) {
    const auto& q = setpoint.q_d;
    const auto& thrust = setpoint.thrust_body;
    return math::is_finite(q[0] + q[1] + q[2] + q[3] + thrust[0] + thrust[1] + thrust[2] +
                           setpoint.yaw_sp_move_rate);
}

// Level, with the heading of q_NB.
Quaternion<float> level(const Quaternion<float>& q_NB) {
    return math::normalized(Quaternion<float>(q_NB.w(), 0.0F, 0.0F, q_NB.z()));
}

// Twice the sines of half the error angles: tilt about x and y, then heading about z, each the
// shorter way. Both factors of the error come in closed form.
Vector3<float> tilt_then_yaw(const Quaternion<float>& error) {
    const float w = error.w();
    const float z = error.z();
    const float cos_half_tilt = math::sqrt(w * w + z * z);
    if (cos_half_tilt < kHeadingUndefined) return {2.0F * error.x(), 2.0F * error.y(), 0.0F};
    const float scale = 2.0F / cos_half_tilt;
    return {scale * (w * error.x() - z * error.y()), scale * (w * error.y() + z * error.x()),
            scale * (w < 0.0F ? -z : z)};
}

// The local down axis in B: the last row of R_NB.
Vector3<float> down_B(const Quaternion<float>& q) {
    return {2.0F * (q.x() * q.z() - q.w() * q.y()), 2.0F * (q.y() * q.z() + q.w() * q.x()),
            1.0F - 2.0F * (q.x() * q.x() + q.y() * q.y())};
}

// Thrust for the tilt that there is, so that a tilt which lags does not cost height.
std::array<float, 3> upheld(const std::array<float, 3>& thrust_B, const Quaternion<float>& wanted,
                            const Quaternion<float>& q_NB) {
    constexpr float kMin = 0.8F;
    constexpr float kMax = 1.25F;
    const float cos_tilt = math::max(down_B(q_NB).z(), 0.1F);
    const float part = math::clamp(down_B(wanted).z() / cos_tilt, kMin, kMax);
    return {thrust_B[0], thrust_B[1], math::max(part * thrust_B[2], -1.0F)};
}

bool is_flown_by_hand(const AttitudeControlPorts& ports) {
    using Nav = VehicleStatus::NavState;
    if (!ports.status) return false;
    return ports.status->nav_state == Nav::kManual || ports.status->nav_state == Nav::kStabilized;
}

bool is_armed(const AttitudeControlPorts& ports) {
    return ports.status && ports.status->arming_state == VehicleStatus::ArmingState::kArmed;
}

// Null: there is none of its kind.
const OffboardSetpoint* offboard(const AttitudeControlPorts& ports, OffboardSetpoint::Kind kind) {
    const bool is_mode =
        ports.status && ports.status->nav_state == VehicleStatus::NavState::kOffboard;
    return is_mode && ports.offboard && ports.offboard->kind == kind ? &*ports.offboard : nullptr;
}

VehicleAttitudeSetpoint attitude_of(const OffboardSetpoint& wanted) {
    const float yaw_rate = math::is_finite(wanted.yawspeed) ? wanted.yawspeed : 0.0F;
    return {.yaw_sp_move_rate = yaw_rate,
            .q_d = wanted.q_d,
            .thrust_body = {0.0F, 0.0F, -wanted.thrust}};
}

bool hears_pilot(const AttitudeControlPorts& ports) {
    return ports.sticks && ports.sticks->valid;
}

Vector3<float> limited(Vector3<float> rates, const AttitudeControlParams& params) {
    const Vector3<float> limit(params.roll_rate_limit, params.pitch_rate_limit,
                               params.yaw_rate_limit);
    for (int i = 0; i < 3; ++i) rates[i] = math::clamp(rates[i], -limit[i], limit[i]);
    return rates;
}

// Least at the lower end, hover in the middle, most at the upper end.
float thrust_of(float throttle, const AttitudeControlParams& params) {
    const float t = math::clamp(throttle, -1.0F, 1.0F);
    const float beyond =
        t < 0.0F ? params.stick_hover - params.stick_least : params.stick_most - params.stick_hover;
    return params.stick_hover + t * beyond;
}

// The sticks as an attitude: tilted as they are, with the heading of q_NB.
VehicleAttitudeSetpoint by_hand(const AttitudeControlPorts& ports, const Quaternion<float>& q_NB) {
    const ManualControlSetpoint& sticks = *ports.sticks;
    const AttitudeControlParams& params = *ports.params;
    const Quaternion<float> q = math::from_euler(math::EulerAngles<float>{
        params.stick_tilt * sticks.roll, -params.stick_tilt * sticks.pitch, math::heading(q_NB)});
    return {.yaw_sp_move_rate = params.stick_yaw_rate * sticks.yaw,
            .q_d = math::to_array(q),
            .thrust_body = {0.0F, 0.0F, -thrust_of(sticks.throttle, params)}};
}

}  // namespace

Vector3<float> AttitudeControl::rates_setpoint(const AttitudeControlPorts& ports) {
    const AttitudeControlParams& params = *ports.params;
    if (const auto* const sent = offboard(ports, OffboardSetpoint::Kind::kRates)) {
        thrust_body_ = {0.0F, 0.0F, -sent->thrust};
        has_setpoint_ = true;
        return limited(math::vector(sent->rates), params);
    }
    const VehicleAttitude& attitude = ports.navigation ? *ports.navigation : *ports.attitude;
    const Quaternion<float> q_NB = math::quaternion(attitude.q);
    Quaternion<float> wanted = level(q_NB);
    float yaw_rate = 0.0F;
    const bool by_sticks = is_flown_by_hand(ports) && hears_pilot(ports);
    // Until the commander decides what follows.
    const bool awaits_pilot = is_flown_by_hand(ports) && !hears_pilot(ports) && is_armed(ports);
    VehicleAttitudeSetpoint setpoint{.q_d = {math::canonical_nan<float>()}};
    if (ports.setpoint && !awaits_pilot) setpoint = *ports.setpoint;
    if (by_sticks) setpoint = by_hand(ports, q_NB);
    const OffboardSetpoint* const sent = offboard(ports, OffboardSetpoint::Kind::kAttitude);
    if (sent != nullptr) setpoint = attitude_of(*sent);
    if (is_usable(setpoint)) {
        wanted = math::quaternion(setpoint.q_d);
        yaw_rate = setpoint.yaw_sp_move_rate;
        thrust_body_ = by_sticks || sent != nullptr ? setpoint.thrust_body
                                                    : upheld(setpoint.thrust_body, wanted, q_NB);
        has_setpoint_ = true;
    }
    if (!has_setpoint_) return Vector3<float>::Zero();

    const Vector3<float> gain(params.tilt_p, params.tilt_p, params.yaw_p);
    Vector3<float> rates = gain.cwiseProduct(tilt_then_yaw(q_NB.conjugate() * wanted));
    rates += yaw_rate * down_B(q_NB);
    return limited(rates, params);
}

void AttitudeControl::step(AttitudeControlPorts& ports) {
    if (!ports.attitude) return;
    const Vector3<float> rates = rates_setpoint(ports);
    ports.rates.publish([&] {
        return VehicleRatesSetpoint{
            .roll = rates.x(), .pitch = rates.y(), .yaw = rates.z(), .thrust_body = thrust_body_};
    });
}

}  // namespace stator::apps::attitude_control
