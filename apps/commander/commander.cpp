// Arming, flight modes, failsafes.
#include "commander.hpp"

#include <algorithm>

#include "stator/elapsed.hpp"

namespace stator::apps::commander {

namespace {

using Nav = VehicleStatus::NavState;
using Switch = ManualControlSwitches;

constexpr float kShortestStep = 1e-3F;
constexpr float kLongestStep = 1.0F;
constexpr float kLowThrottle = -0.9F;
constexpr float kMoves = 0.2F;     // m/s, less than any descent
constexpr float kStands_s = 5.0F;  // without that
constexpr float kHigh = 10.0F;     // m, more than a height is off by
// Setpoints of the mode offboard come at least so often: 2 Hz, with some patience.
constexpr float kProofOfLife_s = 0.6F;
// Of the test of a motor. Stations are heard each second.
constexpr float kStationIsThere_s = 2.5F;
constexpr float kLongestTest_s = 10.0F;

bool knows_height(const CommanderPorts& ports) {
    return ports.position && ports.position->z_valid && ports.position->v_z_valid &&
           math::is_finite(ports.position->z + ports.position->vz);
}

bool knows_position(const CommanderPorts& ports) {
    return ports.position && ports.position->xy_valid && ports.position->v_xy_valid &&
           math::is_finite(ports.position->x + ports.position->y + ports.position->heading);
}

bool sensors_agree(const CommanderPorts& ports) {
    if (!ports.estimator) return true;
    const EstimatorStatus& e = *ports.estimator;
    const float most = math::max(math::max(e.vel_test_ratio, e.pos_test_ratio),
                                 math::max(e.hgt_test_ratio, e.mag_test_ratio));
    return most < ports.params->test_ratio;
}

bool hears_pilot(const CommanderPorts& ports) {
    return ports.sticks && ports.sticks->valid;
}

bool hears_motors(const CommanderPorts& ports) {
    if (!ports.escs) return true;
    const unsigned all = (1U << std::min<unsigned>(ports.escs->esc_count, 16)) - 1;
    return (ports.escs->esc_online_flags & all) == all;
}

bool has_lost_a_motor(const CommanderPorts& ports) {
    return !hears_motors(ports) || (ports.failure && ports.failure->motor_failure_mask != 0);
}

bool is_outside_fence(const CommanderPorts& ports) {
    if (!ports.fence) return false;
    const GeofenceResult& fence = *ports.fence;
    return fence.geofence_max_dist_triggered || fence.geofence_max_alt_triggered ||
           fence.geofence_custom_fence_triggered;
}

bool is_flown_by_hand(Nav mode) {
    return mode == Nav::kManual || mode == Nav::kStabilized || mode == Nav::kAltitude;
}

int32_t mode_of_slot(const CommanderParams& params, unsigned slot) {
    const std::array<int32_t, 6> modes{params.mode1, params.mode2, params.mode3,
                                       params.mode4, params.mode5, params.mode6};
    return slot >= 1 && slot <= modes.size() ? modes[slot - 1] : static_cast<int32_t>(Nav::kHold);
}

// Not while they are loaded, nor if that failed or a circle of restarts made it do without them: it
// must not fly with other gains than its owner thinks.
bool parameters_count(const CommanderPorts& ports) {
    using State = ParameterStatus::State;
    if (!ports.parameters) return true;
    const ParameterStatus& status = *ports.parameters;
    return status.state != State::kLoading && status.state != State::kFailed &&
           status.withheld == 0;
}

}  // namespace

void Commander::take_health(const CommanderPorts& ports, float dt) {
    using Warning = BatteryStatus::Warning;
    HealthReport& h = health_;
    h.sensors_ok = ports.gyro && ports.mag && ports.baro && ports.gnss;
    h.estimator_ok =
        estimate_holds_.update(knows_height(ports) && knows_position(ports) && sensors_agree(ports),
                               dt, ports.params->settle_time);
    h.battery_ok =
        ports.battery && ports.battery->connected && ports.battery->warning == Warning::kNone;
    h.motors_ok = hears_motors(ports) && !is_uncontrolled(ports);
    h.rc_ok = hears_pilot(ports);
    h.logging_ok = static_cast<bool>(ports.log);
    h.parameters_ok = parameters_count(ports);
    h.mission_ok = wish_ != Nav::kMission || (ports.result && ports.result->valid);
    h.can_arm = h.sensors_ok && h.estimator_ok && h.battery_ok && h.motors_ok && h.rc_ok &&
                h.logging_ok && h.parameters_ok && h.mission_ok;
}

// Before the first take-off it is on the ground; then only after it has landed for a while.
void Commander::take_place(const CommanderPorts& ports, float dt) {
    const bool landed = ports.land && ports.land->landed;
    if (is_armed_ && ports.land && !landed) has_flown_ = true;
    const bool is_down = is_down_.update(landed, dt, ports.params->landed_time);
    is_on_ground_ = !is_armed_ || (landed && !has_flown_) || is_down;
    if (knows_height(ports)) {
        height_ = home_.z - ports.position->z;
        blind_for_s_ = 0.0F;
    } else if (mode_ == Nav::kDescend) {
        blind_for_s_ += dt;
    }
}

// Who spoke last, and when.
void Commander::take_silence(const CommanderPorts& ports, float dt) {
    no_setpoint_s_ = ports.offboard.is_new() ? 0.0F : math::min(no_setpoint_s_ + dt, kLong_s);
    no_station_s_ = ports.station.is_new() ? 0.0F : math::min(no_station_s_ + dt, kLong_s);
    if (ports.station) has_heard_station_ = true;
    if (ports.motors) has_heard_motors_ = true;
}

// The rate controller or the allocation is silent, and with it the motors' commands.
bool Commander::is_uncontrolled(const CommanderPorts& ports) const {
    return has_heard_motors_ && !ports.motors;
}

void Commander::take_events(const CommanderPorts& ports, float dt) {
    using Warning = BatteryStatus::Warning;
    const CommanderParams& params = *ports.params;
    const bool battery_known = ports.battery && ports.battery->connected;
    const Warning warning = battery_known ? ports.battery->warning : Warning::kNone;
    const auto set = [this](FailsafeEvent event, bool is_on) {
        events_ = is_on ? events_ | bit(event) : events_ & ~bit(event);
    };
    set(FailsafeEvent::kCrashed, (ports.land && ports.land->crashed) || is_uncontrolled(ports));
    set(FailsafeEvent::kCannotFollow,
        ports.progress && ports.progress->lags_for >= params.lag_limit);
    set(FailsafeEvent::kEstimatorInvalid,
        height_is_gone_.update(!knows_height(ports), dt, params.position_timeout));
    set(FailsafeEvent::kPositionLost,
        position_is_gone_.update(!knows_position(ports), dt, params.position_timeout));
    set(FailsafeEvent::kMotorLost, has_lost_a_motor(ports));
    set(FailsafeEvent::kRcLost, pilot_is_gone_.update(!hears_pilot(ports), dt, params.rc_timeout));
    set(FailsafeEvent::kStationLost, has_heard_station_ && no_station_s_ >= params.station_timeout);
    set(FailsafeEvent::kOffboardLost, no_setpoint_s_ >= params.offboard_timeout);
    set(FailsafeEvent::kGeofence, is_outside_fence(ports));
    set(FailsafeEvent::kMissionLost, !ports.result || !ports.result->valid);
    // A battery does not recover: a load that goes makes it look better for a while.
    const bool is_critical = warning >= Warning::kCritical && warning <= Warning::kFailed;
    if (is_critical) set(FailsafeEvent::kBatteryCritical, true);
    if (warning == Warning::kLow || is_critical) set(FailsafeEvent::kBatteryLow, true);
}

void Commander::choose(const CommanderPorts& ports, Nav mode) {
    // From the ground a return would first climb.
    if (!goes_on(mode, events_, *ports.params) || (mode == Nav::kReturn && is_on_ground_)) return;
    if (mode == Nav::kOffboard && no_setpoint_s_ > kProofOfLife_s) return;
    mode_ = mode;
    failsafe_ = VehicleStatus::FailsafeEvent::kNone;
}

void Commander::arm(const CommanderPorts& ports) {
    is_armed_ = true;
    has_flown_ = false;
    events_ &= ~(bit(FailsafeEvent::kBatteryCritical) | bit(FailsafeEvent::kBatteryLow));
    failsafe_ = VehicleStatus::FailsafeEvent::kNone;
    const VehicleLocalPosition& p = *ports.position;
    home_ = {.x = p.x, .y = p.y, .z = p.z, .yaw = p.heading, .valid_lpos = true};
    stands_.reset();
    idles_.reset();
    is_down_.reset();
    blind_for_s_ = 0.0F;
}

void Commander::disarm() {
    is_armed_ = false;
}

// The pilot's switches. One that is not heard wishes nothing.
void Commander::take_wish(const CommanderPorts& ports, float dt) {
    if (!ports.switches || !hears_pilot(ports)) return;
    const Switch& s = *ports.switches;
    const bool return_is_on = s.return_switch == Switch::ReturnSwitch::kOn;
    const bool moved = s.mode_slot != mode_slot_ || (return_was_on_ && !return_is_on);
    mode_slot_ = s.mode_slot;
    wish_ = static_cast<Nav>(mode_of_slot(*ports.params, s.mode_slot));
    if (moved && !return_is_on) choose(ports, wish_);
    if (return_is_on && !return_was_on_) choose(ports, Nav::kReturn);
    return_was_on_ = return_is_on;
    take_arm_switch(ports, dt);
    const bool kills = s.kill_switch == Switch::KillSwitch::kOn;
    if (kill_holds_.update(kills, dt, ports.params->kill_time) && is_armed_) {
        mode_ = Nav::kTermination;
        disarm();
    }
}

// The switch counts when it goes on, and for `arming_wait` while checks still fail.
void Commander::take_arm_switch(const CommanderPorts& ports, float dt) {
    const bool is_on = ports.switches->arm_switch == Switch::ArmSwitch::kOn;
    const bool may_disarm = ports.land && ports.land->landed;
    if (is_on && !arm_switch_was_on_) arming_left_s_ = ports.params->arming_wait + dt;
    if (!is_on) arming_left_s_ = 0.0F;
    if (!is_on && arm_switch_was_on_ && is_armed_ && may_disarm) disarm();
    arm_switch_was_on_ = is_on;
    if (arming_left_s_ <= 0.0F || is_armed_) return;
    arming_left_s_ -= dt;
    const bool throttle_is_safe = !is_flown_by_hand(wish_) || ports.sticks->throttle < kLowThrottle;
    if (!health_.can_arm || !throttle_is_safe) return;
    arming_left_s_ = 0.0F;
    arm(ports);
    choose(ports, wish_);
}

// What a mission lacks counts only where it would be flown.
VehicleCommandAck::Result Commander::arm_by_command(const CommanderPorts& ports) {
    using Result = VehicleCommandAck::Result;
    if (is_armed_) return Result::kAccepted;
    HealthReport health = health_;
    health.mission_ok = mode_ != Nav::kMission || (ports.result && ports.result->valid);
    const bool is_fit = health.sensors_ok && health.estimator_ok && health.battery_ok &&
                        health.motors_ok && health.rc_ok && health.logging_ok &&
                        health.parameters_ok && health.mission_ok;
    const bool throttle_is_safe = !is_flown_by_hand(mode_) || ports.sticks->throttle < kLowThrottle;
    const bool has_setpoints = mode_ != Nav::kOffboard || no_setpoint_s_ <= kProofOfLife_s;
    if (!is_fit || !throttle_is_safe || !has_setpoints) return Result::kTemporarilyRejected;
    // The end of the flight before is not the begin of this one.
    const bool is_end = mode_ == Nav::kLand || mode_ == Nav::kDescend || mode_ == Nav::kReturn ||
                        mode_ == Nav::kTermination;
    if (is_end) mode_ = Nav::kHold;
    arm(ports);
    return Result::kAccepted;
}

VehicleCommandAck::Result Commander::obey(const CommanderPorts& ports,
                                          const VehicleCommand& command) {
    using Result = VehicleCommandAck::Result;
    const auto result_of = [](bool is_done) {
        return is_done ? Result::kAccepted : Result::kTemporarilyRejected;
    };
    switch (command.action) {
        case VehicleCommand::Action::kArm:
            return arm_by_command(ports);
        case VehicleCommand::Action::kDisarm:
            if (is_armed_ && !(ports.land && ports.land->landed)) return result_of(false);
            disarm();
            return Result::kAccepted;
        case VehicleCommand::Action::kKill:
            if (is_armed_) mode_ = Nav::kTermination;
            disarm();
            return Result::kAccepted;
        case VehicleCommand::Action::kSetMode: {
            const auto mode = static_cast<Nav>(command.nav_state);
            choose(ports, mode);
            return result_of(mode_ == mode);
        }
        case VehicleCommand::Action::kGo:
        case VehicleCommand::Action::kOrbit:
            if (is_armed_ && !is_on_ground_) choose(ports, Nav::kHold);
            return result_of(is_armed_ && !is_on_ground_ && mode_ == Nav::kHold);
        case VehicleCommand::Action::kSetItem:
            if (!ports.result || command.item >= ports.result->seq_total) return Result::kDenied;
            return Result::kAccepted;
        case VehicleCommand::Action::kTestMotor:
            return test_motor(ports, command);
    }
    return Result::kUnsupported;
}

bool Commander::may_test_motors(const CommanderPorts& ports) const {
    const bool kills = ports.switches && ports.switches->kill_switch == Switch::KillSwitch::kOn;
    return !is_armed_ && !kills && ports.land && ports.land->landed && has_heard_station_ &&
           no_station_s_ <= kStationIsThere_s;
}

// One at a time: the newest takes the place of the one before.
VehicleCommandAck::Result Commander::test_motor(const CommanderPorts& ports,
                                                const VehicleCommand& command) {
    using Result = VehicleCommandAck::Result;
    if (!ports.motor_test.is_connected() || !ports.allocation) return Result::kUnsupported;
    const bool is_end = math::is_nan(command.thrust);
    const bool is_possible =
        command.motor < ports.allocation->motor_count &&
        (is_end || (command.thrust >= 0.0F && command.thrust <= 1.0F && command.duration > 0.0F &&
                    command.duration <= kLongestTest_s));
    if (!is_possible) return Result::kDenied;
    if (is_end) {
        test_left_s_ = 0.0F;
        return Result::kAccepted;
    }
    if (!may_test_motors(ports)) return Result::kTemporarilyRejected;
    is_testing_ = true;
    test_left_s_ = command.duration;
    test_ = {.motor = command.motor, .thrust = command.thrust};
    return Result::kAccepted;
}

// Told in each activation, as it counts for a short time. The last one stops the motor at once.
void Commander::run_motor_test(CommanderPorts& ports, float dt) {
    if (!is_testing_) return;
    test_left_s_ -= dt;
    is_testing_ = test_left_s_ > 0.0F && may_test_motors(ports);
    if (!is_testing_) test_.thrust = math::canonical_nan<float>();
    ports.motor_test.publish([&] { return test_; });
}

void Commander::take_command(CommanderPorts& ports) {
    if (!ports.command.is_new()) return;
    const VehicleCommand& command = *ports.command;
    const auto result = obey(ports, command);
    ports.ack.publish([&] { return VehicleCommandAck{.tag = command.tag, .result = result}; });
    if (result != VehicleCommandAck::Result::kAccepted) return;
    ports.accepted.publish([&] { return command; });
}

void Commander::fly(const CommanderPorts& ports, float dt) {
    const bool is_over = ports.result && ports.result->finished &&
                         ports.result->nav_state == static_cast<uint8_t>(mode_);
    if (is_over) {
        const auto reason = failsafe_;  // a return that was forced ends in a landing that was, too
        choose(ports, static_cast<Nav>(ports.result->next_nav_state));
        failsafe_ = reason;
    }
    if (is_on_ground_) {
        const auto reason = disarming(mode_, events_);
        if (reason != VehicleStatus::FailsafeEvent::kNone) {
            failsafe_ = reason;
            return disarm();
        }
    } else {
        const Fallback fallback = fall_back(mode_, events_, *ports.params);
        if (fallback.reason != VehicleStatus::FailsafeEvent::kNone) {
            mode_ = fallback.mode;
            failsafe_ = fallback.reason;
        }
    }
    disarm_where_due(ports, dt);
}

void Commander::disarm_where_due(const CommanderPorts& ports, float dt) {
    const CommanderParams& params = *ports.params;
    const bool landed = ports.land && ports.land->landed;
    const bool comes_down = mode_ == Nav::kLand || mode_ == Nav::kDescend;
    const bool has_landed =
        stands_.update(landed && has_flown_ && comes_down, dt, params.disarm_after);
    const bool waits_in_vain = idles_.update(landed, dt, params.idle_limit);
    const float blind_limit = params.blind_margin + math::max(height_, 0.0F) / params.blind_sink;
    // What is seen to move up or down is not there yet.
    const bool moves =
        ports.position && ports.position->v_z_valid && math::abs(ports.position->vz) > kMoves;
    moved_s_ = moves ? 0.0F : moved_s_ + dt;
    // Nor what the barometer alone sees high up.
    const bool is_high =
        ports.position && ports.position->z_valid && home_.z - ports.position->z > kHigh;
    const bool is_down_by_now = blind_for_s_ >= blind_limit && moved_s_ >= kStands_s && !is_high;
    if (has_landed || waits_in_vain || is_down_by_now || mode_ == Nav::kTermination) disarm();
}

void Commander::step(CommanderPorts& ports) {
    const float dt = seconds_since_last(last_us_, ports.now, kShortestStep, kLongestStep);
    take_health(ports, dt);
    take_place(ports, dt);
    take_silence(ports, dt);
    take_events(ports, dt);
    take_wish(ports, dt);
    take_command(ports);
    run_motor_test(ports, dt);
    if (is_armed_) fly(ports, dt);
    using Arming = VehicleStatus::ArmingState;
    // First home, then the status that starts what needs it.
    ports.home.publish([&] { return home_; });
    ports.health.publish([&] { return health_; });
    ports.status.publish([&] {
        return VehicleStatus{.arming_state = is_armed_ ? Arming::kArmed : Arming::kDisarmed,
                             .nav_state = mode_,
                             .failsafe = failsafe_ != VehicleStatus::FailsafeEvent::kNone,
                             .failsafe_event = failsafe_};
    });
}

}  // namespace stator::apps::commander
