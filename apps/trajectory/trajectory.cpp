// Smooth motion to goals or by sticks.
#include "trajectory.hpp"

#include "stator/elapsed.hpp"

namespace stator::apps::trajectory {

using math::Vector3;

namespace {

constexpr float kNaN = math::canonical_nan<float>();
constexpr float kGravity = 9.80665F;
constexpr float kShortestStep = 1e-3F;
constexpr float kLongestStep = 0.1F;
constexpr float kEndless = 2000.0F;  // m, below any ground
constexpr float kOutOfReach = 2.0F;  // of the limit of lag: gusts alone do not carry it so far
constexpr float kLongestLag_s = 1e4F;
constexpr float kTurnGain = 2.0F;  // 1/s

constexpr TrajectorySetpoint kFree{.timestamp = 0,
                                   .position = {kNaN, kNaN, kNaN},
                                   .velocity = {kNaN, kNaN, kNaN},
                                   .acceleration = {kNaN, kNaN, kNaN},
                                   .yaw = kNaN,
                                   .yawspeed = kNaN};

Vector3<float> with_length_limit(const Vector3<float>& v, float limit) {
    const float length = math::norm(v);
    return length > limit ? Vector3<float>(v * (limit / length)) : v;
}

// Turned by `heading` about down.
Vector3<float> turned(const Vector3<float>& v, float heading) {
    const math::SinCos<float> by = math::sincos(heading);
    return {by.cos * v.x() - by.sin * v.y(), by.sin * v.x() + by.cos * v.y(), v.z()};
}

float or_default(float value, float fallback) {
    return value > 0.0F ? value : fallback;  // not a number is not above 0
}

// The limits along a direction of unit length whose parts have their own.
ProfileLimits along(const Vector3<float>& direction, const ProfileLimits& level,
                    const ProfileLimits& vertical) {
    const float level_part = math::norm(direction.head<2>());
    const float vertical_part = math::abs(direction.z());
    constexpr float kNone = 1e-3F;
    if (vertical_part < kNone) return level;
    if (level_part < kNone) return vertical;
    return {math::min(level.speed / level_part, vertical.speed / vertical_part),
            math::min(level.acceleration / level_part, vertical.acceleration / vertical_part),
            level.jerk};
}

// A goal with a place or size that is none leads nowhere.
bool is_finite(const Leg& leg) {
    const PathState midway = leg.at(0.5F * leg.duration());
    const Vector3<float> sum = midway.position + midway.velocity + midway.acceleration;
    return math::is_finite(leg.duration() + sum.sum());
}

}  // namespace

Trajectory::Task Trajectory::task_of(const TrajectoryPorts& ports) {
    using Nav = VehicleStatus::NavState;
    const bool armed =
        ports.status && ports.status->arming_state == VehicleStatus::ArmingState::kArmed;
    if (!armed) return Task::kFollow;
    switch (ports.status->nav_state) {
        case Nav::kHold:
        case Nav::kTakeoff:
        case Nav::kMission:
        case Nav::kReturn:
        case Nav::kLand:
            return Task::kGoal;
        case Nav::kPosition:
            return Task::kSpeeds;
        case Nav::kAltitude:
            return Task::kHeightOnly;
        case Nav::kOffboard:
            return Task::kOffboard;
        case Nav::kDescend:
            return Task::kSink;
        default:
            return Task::kFollow;
    }
}

// Of the estimate only what is valid; what is not stays as it was.
void Trajectory::follow_estimate(const TrajectoryPorts& ports) {
    if (!ports.position) return;
    const VehicleLocalPosition& p = *ports.position;
    if (p.xy_valid) state_.position.head<2>() << p.x, p.y;
    if (p.z_valid) state_.position.z() = p.z;
    state_.velocity.setZero();
    if (p.v_xy_valid) state_.velocity.head<2>() << p.vx, p.vy;
    if (p.v_z_valid) state_.velocity.z() = p.vz;
    state_.acceleration.setZero();
    if (math::is_finite(p.heading)) heading_ = p.heading;
    yaw_rate_ = 0.0F;
}

void Trajectory::take_goal(const GotoSetpoint& goal, const TrajectoryParams& params) {
    has_goal_ = true;
    goal_number_ = goal.number;
    limits_ = params;
    limits_.speed = or_default(goal.max_horizontal_speed, params.speed);
    limits_.climb_rate = or_default(goal.max_vertical_speed, params.climb_rate);
    limits_.descent_rate = or_default(goal.max_vertical_speed, params.descent_rate);
    const Stop stop(state_, {params.speed, params.acceleration, params.jerk});
    const Leg leg = leg_to(goal, stop.rest());
    plan_ = MotionPlan(stop, is_finite(leg) ? leg : Leg());
    plan_time_ = 0.0F;
    shift_N_.setZero();
}

Leg Trajectory::leg_to(const GotoSetpoint& goal, const Vector3<float>& rest) const {
    const TrajectoryParams& l = limits_;
    switch (goal.kind) {
        case GotoSetpoint::Kind::kPosition: {
            const Vector3<float> way = math::vector(goal.position) - rest;
            const float vertical_speed = way.z() < 0.0F ? l.climb_rate : l.descent_rate;
            return Leg::line(way, along(math::normalized(way), {l.speed, l.acceleration, l.jerk},
                                        {vertical_speed, l.vertical_acceleration, l.jerk}));
        }
        case GotoSetpoint::Kind::kLand:
            return Leg::line({0.0F, 0.0F, kEndless},
                             {l.landing_rate, l.vertical_acceleration, l.jerk});
        case GotoSetpoint::Kind::kCircle: {
            const Vector3<float> out = rest - math::vector(goal.position);
            return Leg::circle(math::atan2(out.y(), out.x()), goal.length, goal.laps,
                               {l.speed, l.eight_acceleration, l.jerk});
        }
        case GotoSetpoint::Kind::kEight:
            return Leg::eight(math::is_finite(goal.heading) ? goal.heading : 0.0F, goal.length,
                              goal.laps, {l.speed, l.eight_acceleration, l.jerk});
        default:
            return {};
    }
}

// The pace of the plan. A vehicle that lags far behind, in a gust or at the end of its thrust, is
// waited for; a landing is not, as below there is less wind and nothing to lose.
float Trajectory::wait_for(const TrajectoryPorts& ports, float dt) {
    const TrajectoryParams& params = *ports.params;
    if (!ports.position || !ports.position->xy_valid || !ports.position->z_valid) return 1.0F;
    const VehicleLocalPosition& p = *ports.position;
    const float lag = math::norm(state_.position.head<2>() - Eigen::Vector2f(p.x, p.y));
    const float below = p.z - state_.position.z();
    const bool is_far = math::max(lag, below) > kOutOfReach * params.lag_limit;
    lags_for_s_ = is_far ? math::min(lags_for_s_ + dt, kLongestLag_s) : 0.0F;
    const bool lands = ports.goal && ports.goal->kind == GotoSetpoint::Kind::kLand;
    if (lands || (ports.status && ports.status->nav_state == VehicleStatus::NavState::kLand)) {
        come_along(p, params.lag_limit);
        return 1.0F;
    }
    return math::clamp(2.0F - 2.0F * lag / params.lag_limit, 0.0F, 1.0F);
}

// Moves the plan so that the setpoint is at most this far from the vehicle, horizontally and above.
void Trajectory::come_along(const VehicleLocalPosition& position, float most) {
    const Vector3<float> ahead =
        state_.position - Vector3<float>(position.x, position.y, position.z);
    const float lag = math::norm(ahead.head<2>());
    if (lag > most) shift_N_.head<2>() -= ahead.head<2>() * (1.0F - most / lag);
    if (-ahead.z() > most) shift_N_.z() -= ahead.z() + most;
}

void Trajectory::advance_goal(const TrajectoryPorts& ports, float dt) {
    const TrajectoryParams& params = *ports.params;
    const bool is_other = ports.goal && (!has_goal_ || ports.goal->number != goal_number_);
    if (is_other) take_goal(*ports.goal, params);
    if (!has_goal_) return;
    pace_ = wait_for(ports, dt);
    plan_time_ = math::min(plan_time_ + pace_ * dt, plan_.duration());
    state_ = plan_.at(plan_time_);
    state_.position += shift_N_;
    const bool is_eight = ports.goal && ports.goal->kind == GotoSetpoint::Kind::kEight;
    turn(ports.goal && !is_eight ? ports.goal->heading : kNaN, params, dt);
}

// The pilot's sticks as speeds: to the front, the right and up, as the nose points.
void Trajectory::advance_speeds(const TrajectoryPorts& ports, float dt) {
    const TrajectoryParams& params = *ports.params;
    const ManualControlSetpoint sticks =
        ports.sticks && ports.sticks->valid ? *ports.sticks : ManualControlSetpoint{};
    const float vertical_speed = sticks.throttle > 0.0F ? params.climb_rate : params.descent_rate;
    const Vector3<float> wanted = turned({sticks.pitch * params.speed, sticks.roll * params.speed,
                                          -sticks.throttle * vertical_speed},
                                         heading_);
    if (ports.land && ports.land->landed && !(wanted.z() < 0.0F)) {
        follow_estimate(ports);
        state_.velocity.setZero();  // of an estimate that drifts
        return;
    }
    const Vector3<float> change = params.stick_response * (wanted - state_.velocity);
    const Vector3<float> jump =
        with_length_limit(change, params.acceleration) - state_.acceleration;
    state_.acceleration += with_length_limit(jump, params.jerk * dt);
    state_.velocity += state_.acceleration * dt;
    state_.position += state_.velocity * dt;
    const float most = params.yaw_acceleration * dt;
    yaw_rate_ += math::clamp(sticks.yaw * params.yaw_rate - yaw_rate_, -most, most);
    heading_ = math::wrap_pi(heading_ + yaw_rate_ * dt);
    if (task_ != Task::kHeightOnly || !ports.position) return;
    const VehicleLocalPosition& p = *ports.position;
    if (p.xy_valid && math::is_finite(p.x + p.y)) state_.position.head<2>() << p.x, p.y;
    const float pull = kGravity * math::tan(params.stick_tilt);
    state_.acceleration.head<2>() =
        turned({sticks.pitch * pull, sticks.roll * pull, 0.0F}, heading_).head<2>();
}

void Trajectory::follow_offboard(const TrajectoryPorts& ports, float dt) {
    const float heading = heading_;
    follow_estimate(ports);
    if (!ports.offboard || ports.offboard->kind != OffboardSetpoint::Kind::kMotion) return;
    const OffboardSetpoint& wanted = *ports.offboard;
    yaw_rate_ = math::is_finite(wanted.yawspeed) ? wanted.yawspeed : 0.0F;
    heading_ = math::is_finite(wanted.yaw) ? wanted.yaw : math::wrap_pi(heading + yaw_rate_ * dt);
}

// From the ground to a place above, it climbs; a place alone would not say so.
TrajectorySetpoint Trajectory::offboard_setpoint(const TrajectoryPorts& ports) const {
    constexpr float kAbove = 0.2F;   // m
    constexpr float kClimbs = 0.3F;  // m/s
    TrajectorySetpoint result = kFree;
    if (!ports.offboard) {
        result.velocity = {0.0F, 0.0F, 0.0F};
        return result;
    }
    const OffboardSetpoint& wanted = *ports.offboard;
    if (wanted.kind != OffboardSetpoint::Kind::kMotion) return result;
    result.position = wanted.position;
    result.velocity = wanted.velocity;
    result.acceleration = wanted.acceleration;
    result.yaw = heading_;
    result.yawspeed = yaw_rate_;
    const bool is_above = wanted.position[2] < state_.position.z() - kAbove;
    const bool stands = ports.land && ports.land->landed;
    if (stands && is_above && math::is_nan(wanted.velocity[2])) result.velocity[2] = -kClimbs;
    return result;
}

// To a heading, the shorter way; not a number: no further.
void Trajectory::turn(float heading, const TrajectoryParams& params, float dt) {
    const float error = math::is_finite(heading) ? math::wrap_pi(heading - heading_) : 0.0F;
    const float wanted = math::clamp(kTurnGain * error, -params.yaw_rate, params.yaw_rate);
    const float most = params.yaw_acceleration * dt;
    yaw_rate_ += math::clamp(wanted - yaw_rate_, -most, most);
    heading_ = math::wrap_pi(heading_ + yaw_rate_ * dt);
}

TrajectorySetpoint Trajectory::setpoint(const TrajectoryPorts& ports) const {
    TrajectorySetpoint result = kFree;
    if (task_ == Task::kOffboard) return offboard_setpoint(ports);
    if (task_ == Task::kFollow || (task_ == Task::kGoal && !has_goal_)) return result;
    if (task_ == Task::kSink) {
        // Standing over the ground, if something says how fast that goes by.
        result.velocity = {0.0F, 0.0F, ports.params->landing_rate};
        result.yawspeed = 0.0F;
        return result;
    }
    result.position = math::to_array(state_.position);
    const Vector3<float> velocity = pace_ * state_.velocity;
    result.velocity = math::to_array(velocity);
    result.acceleration = math::to_array(state_.acceleration);
    result.yaw = heading_;
    result.yawspeed = yaw_rate_;
    if (task_ != Task::kHeightOnly) return result;
    result.position[0] = result.position[1] = kNaN;
    result.velocity[0] = result.velocity[1] = kNaN;
    return result;
}

void Trajectory::step(TrajectoryPorts& ports) {
    const float dt = seconds_since_last(last_us_, ports.now, kShortestStep, kLongestStep);
    task_ = task_of(ports);
    if (task_ != Task::kGoal) {
        has_goal_ = false;
        pace_ = 1.0F;
        lags_for_s_ = 0.0F;
    }
    if (task_ == Task::kFollow || task_ == Task::kSink) follow_estimate(ports);
    if (task_ == Task::kOffboard) follow_offboard(ports, dt);
    if (task_ == Task::kGoal) advance_goal(ports, dt);
    if (task_ == Task::kSpeeds || task_ == Task::kHeightOnly) advance_speeds(ports, dt);
    ports.setpoint.publish([&] { return setpoint(ports); });
    ports.progress.publish([&] {
        return TrajectoryProgress{.goal = goal_number_,
                                  .is_done = has_goal_ && plan_time_ >= plan_.duration(),
                                  .lags_for = lags_for_s_};
    });
}

}  // namespace stator::apps::trajectory
