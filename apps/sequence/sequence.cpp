// A flight from parameters: arms, takes off, hovers, lands, disarms.
#include "sequence.hpp"

#include <algorithm>

#include "stator/elapsed.hpp"

namespace stator::apps::sequence {

using math::Vector3;

namespace {

constexpr float kNaN = math::canonical_nan<float>();
constexpr float kShortestStep = 1e-3F;
constexpr float kLongestStep = 0.1F;
constexpr float kEndless = 1000.0F;  // m
constexpr float kTurned = 0.01F;     // rad/s

constexpr uint64_t kPositionTooOld_us = 300'000;
constexpr float kPositionLost_s = 0.5F;

// On the ground the setpoint sinks on, while the vehicle neither follows nor moves.
constexpr float kTouchdownLag = 0.25F;   // m
constexpr float kTouchdownSpeed = 0.1F;  // m/s
constexpr float kTouchdownTime_s = 0.5F;
// At the height of the take-off the ground is certain, and time is short: a vehicle that leans into
// the wind while the ground levels it falls over if it flies on.
constexpr float kAtGround = 0.15F;  // m, where a leaning one stands on a foot
constexpr float kTouchdownTimeAtGround_s = 0.2F;

// A landing without position may take twice its planned time and this.
constexpr float kBlindMargin_s = 5.0F;

Vector3<float> up() {
    return {0.0F, 0.0F, -1.0F};
}
Vector3<float> down() {
    return {0.0F, 0.0F, 1.0F};
}

bool is_good(const SequencePorts& ports) {
    if (!ports.position) return false;
    const VehicleLocalPosition& p = *ports.position;
    const bool is_old = ports.now > p.timestamp_sample + kPositionTooOld_us;
    const bool is_valid = p.xy_valid && p.z_valid && p.v_xy_valid && p.v_z_valid;
    const bool is_number = math::is_finite(p.x + p.y + p.z + p.vx + p.vy + p.vz + p.heading);
    return is_valid && is_number && !is_old;
}

bool hears_all(const EscStatus& escs) {
    const unsigned all = (1U << std::min<unsigned>(escs.esc_count, 16)) - 1;
    return (escs.esc_online_flags & all) == all;
}

}  // namespace

void Sequence::take_position(const SequencePorts& ports, float dt) {
    const bool good = is_good(ports);
    good_for_s_ = good ? good_for_s_ + dt : 0.0F;
    bad_for_s_ = good ? 0.0F : bad_for_s_ + dt;
    if (!good) return;
    const VehicleLocalPosition& p = *ports.position;
    position_N_ = {p.x, p.y, p.z};
    down_speed_ = p.vz;
    heading_ = p.heading;
}

bool Sequence::position_is_lost() const {
    return bad_for_s_ > kPositionLost_s;
}

void Sequence::begin(Phase phase) {
    phase_ = phase;
    in_phase_s_ = 0.0F;
    yaw_rate_ = 0.0F;
}

void Sequence::begin_landing(const SequenceParams& params) {
    leg_ = StraightLeg(position_is_lost() ? position_N_ : leg_.position(), down(), kEndless);
    const float height = math::max(ground_z_ - position_N_.z(), 0.0F);
    blind_left_s_ = 2.0F * height / params.landing_rate + kBlindMargin_s;
    begin(Phase::kLand);
}

Sequence::Event Sequence::what_forces_down() const {
    if (position_is_lost()) return Event::kPositionLost;
    return motor_is_lost_ ? Event::kMotorLost : Event::kNone;
}

void Sequence::wait(const SequenceParams& params) {
    if (!is_ready() || good_for_s_ < params.start_delay) return;
    ground_z_ = position_N_.z();
    leg_ = StraightLeg(position_N_, up(), 0.0F);
    yaw_ = heading_;
    begin(Phase::kSpoolUp);
}

void Sequence::spool_up(const SequenceParams& params) {
    if (!is_ready()) {
        begin(Phase::kWait);
    } else if (in_phase_s_ >= params.spool_up_time) {
        leg_ = StraightLeg(position_N_, up(), params.height);
        begin(Phase::kClimb);
    }
}

void Sequence::climb(const SequenceParams& params, float dt) {
    leg_.advance(params.takeoff_rate, params.acceleration, dt);
    if (!leg_.is_at_rest()) return;
    const Vector3<float> hover_N(params.north, params.east, ground_z_ - params.height);
    leg_ = StraightLeg::between(leg_.position(), hover_N);
    begin(Phase::kApproach);
}

void Sequence::approach(const SequenceParams& params, float dt) {
    turn(params, dt);
    leg_.advance(params.speed, params.acceleration, dt);
    if (leg_.is_at_rest() && math::abs(yaw_rate_) < kTurned) begin(Phase::kHover);
}

void Sequence::turn(const SequenceParams& params, float dt) {
    const float most = params.yaw_rate * dt;
    const float change = math::clamp(math::wrap_pi(params.heading - yaw_), -most, most);
    yaw_ = math::wrap_pi(yaw_ + change);
    yaw_rate_ = change / dt;
}

void Sequence::land(const SequenceParams& params, float dt) {
    if (position_is_lost()) {
        is_blind_ = true;
        blind_left_s_ -= dt;
        if (blind_left_s_ <= 0.0F) begin(Phase::kDone);
        return;
    }
    if (is_blind_) leg_ = StraightLeg(position_N_, down(), kEndless);
    is_blind_ = false;
    leg_.advance(params.landing_rate, params.acceleration, dt);
    if (has_touched_down(dt)) begin(Phase::kDone);
}

bool Sequence::has_touched_down(float dt) {
    const bool lags = leg_.position().z() - position_N_.z() > kTouchdownLag;
    const bool is_still = math::abs(down_speed_) < kTouchdownSpeed;
    const bool at_ground = math::abs(ground_z_ - position_N_.z()) < kAtGround;
    const bool stands = bad_for_s_ == 0.0F && is_still && (lags || at_ground);
    still_for_s_ = stands ? still_for_s_ + dt : 0.0F;
    return still_for_s_ >= (at_ground ? kTouchdownTimeAtGround_s : kTouchdownTime_s);
}

void Sequence::advance(const SequenceParams& params, float dt) {
    in_phase_s_ += dt;
    const bool is_flying =
        phase_ == Phase::kClimb || phase_ == Phase::kApproach || phase_ == Phase::kHover;
    if (is_flying && what_forces_down() != Event::kNone) {
        failsafe_ = what_forces_down();
        begin_landing(params);
    }
    switch (phase_) {
        case Phase::kWait:
            return wait(params);
        case Phase::kSpoolUp:
            return spool_up(params);
        case Phase::kClimb:
            return climb(params, dt);
        case Phase::kApproach:
            return approach(params, dt);
        case Phase::kHover:
            leg_.advance(params.speed, params.acceleration, dt);
            if (in_phase_s_ >= params.hover_time) begin_landing(params);
            return;
        case Phase::kLand:
            return land(params, dt);
        case Phase::kDone:
            return;
    }
}

TrajectorySetpoint Sequence::setpoint(const SequenceParams& params) const {
    const bool follows_leg = phase_ != Phase::kWait && phase_ != Phase::kDone && !is_blind_;
    if (follows_leg) {
        return {.position = math::to_array(leg_.position()),
                .velocity = math::to_array(leg_.velocity()),
                .acceleration = math::to_array(leg_.acceleration()),
                .yaw = yaw_,
                .yawspeed = yaw_rate_};
    }
    const float sink = phase_ == Phase::kLand ? params.landing_rate : 0.0F;
    return {.position = {kNaN, kNaN, kNaN},
            .velocity = {0.0F, 0.0F, sink},
            .acceleration = {},
            .yaw = kNaN,
            .yawspeed = 0.0F};
}

VehicleStatus Sequence::status() const {
    using Arming = VehicleStatus::ArmingState;
    using Nav = VehicleStatus::NavState;
    const bool armed = phase_ != Phase::kWait && phase_ != Phase::kDone;
    Nav nav_state = Nav::kHold;
    if (phase_ == Phase::kSpoolUp || phase_ == Phase::kClimb) nav_state = Nav::kTakeoff;
    if (phase_ == Phase::kLand || phase_ == Phase::kDone) nav_state = Nav::kLand;
    return {.arming_state = armed ? Arming::kArmed : Arming::kDisarmed,
            .nav_state = nav_state,
            .failsafe = failsafe_ != Event::kNone,
            .failsafe_event = failsafe_};
}

void Sequence::step(SequencePorts& ports) {
    const float dt = seconds_since_last(last_us_, ports.now, kShortestStep, kLongestStep);
    take_position(ports, dt);
    motor_is_lost_ = ports.escs && !hears_all(*ports.escs);
    advance(*ports.params, dt);
    ports.setpoint.publish([&] { return setpoint(*ports.params); });
    ports.status.publish([&] { return status(); });
}

}  // namespace stator::apps::sequence
