// Position and velocity control: from a trajectory setpoint to an attitude setpoint.
#include "position_control.hpp"

#include "stator/elapsed.hpp"

namespace stator::apps::position_control {

using math::Quaternion;
using math::Vector3;

namespace {

constexpr float kNaN = math::canonical_nan<float>();
constexpr float kShortestStep = 1e-3F;
constexpr float kLongestStep = 0.1F;
constexpr uint64_t kPositionLost_us = 300'000;

// A horizontal and a vertical value as a vector of N.
Vector3<float> per_axis(float horizontal, float vertical) {
    return {horizontal, horizontal, vertical};
}

MotionEstimate estimate_of(const VehicleLocalPosition& position) {
    MotionEstimate estimate{
        {position.x, position.y, position.z}, {position.vx, position.vy, position.vz}, kNaN};
    if (!position.xy_valid) estimate.position_N.head<2>().setConstant(kNaN);
    if (!position.z_valid) estimate.position_N.z() = kNaN;
    if (!position.v_xy_valid) estimate.velocity_N.head<2>().setConstant(kNaN);
    if (!position.v_z_valid) estimate.velocity_N.z() = kNaN;
    return estimate;
}

constexpr TrajectorySetpoint kStandStill{.timestamp = 0,
                                         .position = {kNaN, kNaN, kNaN},
                                         .velocity = {},
                                         .acceleration = {},
                                         .yaw = kNaN,
                                         .yawspeed = 0.0F};

// Leaves attitude_control the thrust that it has.
constexpr VehicleAttitudeSetpoint kNoWish{.timestamp = 0,
                                          .yaw_sp_move_rate = kNaN,
                                          .q_d = {kNaN, kNaN, kNaN, kNaN},
                                          .thrust_body = {kNaN, kNaN, kNaN}};

bool is_armed(const PositionControlPorts& ports) {
    return ports.status && ports.status->arming_state == VehicleStatus::ArmingState::kArmed;
}

bool is_flown_by_hand(const PositionControlPorts& ports) {
    using Nav = VehicleStatus::NavState;
    if (!ports.status) return false;
    return ports.status->nav_state == Nav::kManual || ports.status->nav_state == Nav::kStabilized;
}

// An attitude or rates, of the mode offboard.
bool is_motion_free(const PositionControlPorts& ports) {
    const bool is_offboard =
        ports.status && ports.status->nav_state == VehicleStatus::NavState::kOffboard;
    if (!is_offboard || !ports.setpoint) return false;
    const TrajectorySetpoint& s = *ports.setpoint;
    const auto is_free = [](const std::array<float, 3>& v) {
        return math::is_nan(v[0]) && math::is_nan(v[1]) && math::is_nan(v[2]);
    };
    return is_free(s.position) && is_free(s.velocity) && is_free(s.acceleration);
}

bool stands(const PositionControlPorts& ports) {
    return ports.land && ports.land->landed;
}
bool flies(const PositionControlPorts& ports) {
    return ports.land && !ports.land->landed;
}

// On the ground, where a vehicle that holds its position leans into the wind, and falls over.
bool rests(const PositionControlPorts& ports) {
    constexpr float kClimbs = -0.02F;  // m/s
    const bool should_climb = ports.setpoint && ports.setpoint->velocity[2] < kClimbs;
    return stands(ports) && !should_climb;
}

void publish_attitude(PositionControlPorts& ports, const Vector3<float>& thrust_N, float yaw,
                      float yaw_rate) {
    const Vector3<float> down_B = -thrust_N;  // the body's z axis in N; level without thrust
    const Quaternion<float> q = math::from_body_z_and_yaw(down_B, yaw);
    const float thrust = math::norm(thrust_N);
    ports.attitude_setpoint.publish([&] {
        return VehicleAttitudeSetpoint{.yaw_sp_move_rate = yaw_rate,
                                       .q_d = math::to_array(q),
                                       .thrust_body = {0.0F, 0.0F, -thrust}};
    });
}

}  // namespace

void PositionControl::configure(const PositionControlParams& p) {
    motion_.set_gains({.position_p = per_axis(p.horizontal_p, p.vertical_p),
                       .velocity_p = per_axis(p.horizontal_velocity_p, p.vertical_velocity_p),
                       .velocity_i = per_axis(p.horizontal_velocity_i, p.vertical_velocity_i),
                       .velocity_d = per_axis(p.horizontal_velocity_d, p.vertical_velocity_d),
                       .derivative_cutoff = math::kTwoPi<float> * p.derivative_cutoff,
                       .integral_limit = p.integral_limit});
    motion_.set_limits({.horizontal_speed = p.horizontal_speed_limit,
                        .climb = p.climb_limit,
                        .descent = p.descent_limit,
                        .tan_tilt = math::tan(p.tilt_limit),
                        .lean_margin = p.lean_margin,
                        .thrust_min = p.thrust_min,
                        .hover_thrust = p.hover_thrust,
                        .blind_sink = p.blind_sink,
                        .drag = p.drag});
    hover_.restart(p.hover_thrust);
}

// False while there is nothing to act on: no position now, and none is missed yet.
bool PositionControl::take_position(const PositionControlPorts& ports) {
    if (ports.position) {
        estimate_ = estimate_of(*ports.position);
        estimate_.climb = climb_of(*ports.position);
        if (math::is_finite(ports.position->heading)) heading_ = ports.position->heading;
        last_position_us_ = ports.now;
        return true;
    }
    if (ports.now - last_position_us_ < kPositionLost_us) return false;
    estimate_ = {per_axis(kNaN, kNaN), per_axis(kNaN, kNaN), kNaN};
    return true;
}

// From heights, low-passed; a reset of them does not count as motion.
float PositionControl::climb_of(const VehicleLocalPosition& position) {
    constexpr float kSmoothing_s = 0.5F;
    const float dt = seconds_since_last(climb_us_, position.timestamp_sample, 0.0F, kLongestStep);
    const bool goes_on = position.z_valid && math::is_finite(height_) && dt > 0.0F &&
                         z_resets_ == position.z_reset_counter;
    const float climb = goes_on ? (-position.z - height_) / dt : climb_;
    climb_ += (climb - climb_) * (dt / (kSmoothing_s + dt));
    height_ = position.z_valid ? -position.z : kNaN;
    z_resets_ = position.z_reset_counter;
    return position.z_valid ? climb_ : kNaN;
}

// Rises from nothing after arming or standing, so that the motors do not jump to hover.
float PositionControl::thrust_max(const PositionControlParams& params, float dt) {
    armed_for_s_ = math::min(armed_for_s_ + dt, params.spool_up_time);
    return params.thrust_max * armed_for_s_ / params.spool_up_time;
}

// In flight alone: on the ground, it carries the rest.
void PositionControl::learn_hover_thrust(const PositionControlPorts& ports, float dt) {
    if (!flies(ports)) return hover_.restart(ports.params->hover_thrust);
    hover_.update(-thrust_N_.z(), estimate_.velocity_N.z(), dt, ports.params->hover_time_constant);
    motion_.set_hover_thrust(hover_.value());
}

void PositionControl::step(PositionControlPorts& ports) {
    const PositionControlParams& params = *ports.params;
    if (ports.params.is_new()) configure(params);
    if (!take_position(ports)) return;
    const uint64_t time_us = ports.position ? ports.position->timestamp_sample : ports.now;
    const float dt = seconds_since_last(last_us_, time_us, kShortestStep, kLongestStep);
    const bool armed = is_armed(ports);
    if (armed && (is_flown_by_hand(ports) || is_motion_free(ports))) {
        motion_.reset();
        armed_for_s_ = 0.0F;
        ports.attitude_setpoint.publish([] { return kNoWish; });
        return;
    }
    if (!armed || rests(ports)) {
        // A vehicle that only seemed to have landed goes on with the integral it had.
        if (!armed) motion_.reset();
        armed_for_s_ = 0.0F;
        // On the ground enough to stay upright in a gust.
        const float idle = armed && rests(ports) ? params.thrust_min : 0.0F;
        publish_attitude(ports, {0.0F, 0.0F, -idle}, heading_, 0.0F);
        return;
    }
    if (armed_for_s_ == 0.0F && stands(ports)) motion_.reset();
    if (flies(ports)) armed_for_s_ = params.spool_up_time;
    const TrajectorySetpoint& setpoint = ports.setpoint ? *ports.setpoint : kStandStill;
    const float most = thrust_max(params, dt);
    learn_hover_thrust(ports, dt);
    thrust_N_ = motion_.update(estimate_, setpoint, dt, most);
    const float yaw = math::is_finite(setpoint.yaw) ? setpoint.yaw : heading_;
    const float yaw_rate = math::is_finite(setpoint.yawspeed) ? setpoint.yawspeed : 0.0F;
    publish_attitude(ports, thrust_N_, yaw, yaw_rate);
}

}  // namespace stator::apps::position_control
