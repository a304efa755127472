// Paths, take-off and landing of an aeroplane.
#include "fw_guidance.hpp"

#include "stator/elapsed.hpp"

namespace stator::apps::fw_guidance {

namespace {

using Nav = VehicleStatus::NavState;

constexpr float kNaN = math::canonical_nan<float>();
constexpr float kGravity = 9.80665F;
constexpr float kShortestStep = 1e-3F;
constexpr float kLongestStep = 0.1F;
constexpr float kAbove = 1.0F;        // m, of a goal that starts a take-off
constexpr float kRotates = 0.9F;      // of the take-off airspeed
constexpr float kIsOff = 1.5F;        // m: it flies
constexpr float kGentleBank = 0.26F;  // rad, of a descent without position
constexpr float kLow = 3.0F;          // m, where that descent flares
constexpr float kFlarePitch = 0.12F;  // rad, without power
constexpr float kPowerless = 1.0F;    // m, of a flare
constexpr float kFarBelow = 8.0F;     // m, below the wanted height
constexpr float kSinks = 0.3F;        // m/s
constexpr float kLongest_s = 1e4F;
constexpr float kWindCounts = 2.0F;     // m/s: less has no direction to land into
constexpr float kSlowRoll = 8.0F;       // m/s through the air: no lift to speak of
constexpr float kSlowest = 3.0F;        // m/s over ground, of a landing
constexpr float kRollPitch = 0.01F;     // rad, of the roll after a touchdown
constexpr float kTailDownPitch = 0.2F;  // rad, when it is slow
constexpr float kTurnBank = 0.7F;       // rad, of the turn at a corner
constexpr float kTurnLag = 0.5F;        // s, until it is banked
constexpr float kLanePull = 0.02F;      // rad/m, of the roll back to its line

constexpr FixedWingLongitudinalSetpoint kFree{.timestamp = 0,
                                              .altitude = kNaN,
                                              .height_rate = kNaN,
                                              .equivalent_airspeed = kNaN,
                                              .pitch_direct = kNaN,
                                              .throttle_direct = kNaN};
constexpr FixedWingLateralSetpoint kStraight{
    .timestamp = 0, .lateral_acceleration = 0.0F, .yaw_rate = kNaN};
constexpr TrajectorySetpoint kNoSetpoint{.timestamp = 0,
                                         .position = {kNaN, kNaN, kNaN},
                                         .velocity = {kNaN, kNaN, kNaN},
                                         .acceleration = {kNaN, kNaN, kNaN},
                                         .yaw = kNaN,
                                         .yawspeed = kNaN};

bool follows_goals(Nav mode) {
    return mode == Nav::kHold || mode == Nav::kTakeoff || mode == Nav::kMission ||
           mode == Nav::kReturn || mode == Nav::kLand;
}

NpfgGains gains_of(const FwGuidanceParams& params) {
    return {.period = params.period, .damping = params.damping};
}

// How far ahead of a corner of 90 deg the turn begins that ends on the next leg.
float turn_distance(float ground_speed) {
    return math::square(ground_speed) / (kGravity * math::tan(kTurnBank)) + kTurnLag * ground_speed;
}

float bearing_of(const Vector2& way) {
    return math::atan2(way.y(), way.x());
}

}  // namespace

void FwGuidance::take_inputs(const FwGuidancePorts& ports) {
    const VehicleLocalPosition& p = *ports.position;
    if (p.xy_valid && math::is_finite(p.x + p.y)) position_ = {p.x, p.y};
    if (p.v_xy_valid && math::is_finite(p.vx + p.vy)) velocity_ = {p.vx, p.vy};
    if (p.z_valid && math::is_finite(p.z)) altitude_ = -p.z;
    climb_ = p.v_z_valid && math::is_finite(p.vz) ? -p.vz : 0.0F;
    if (math::is_finite(p.heading)) heading_ = p.heading;
    knows_wind_ = ports.wind && ports.wind->valid;
    wind_.setZero();
    if (knows_wind_) wind_ = {ports.wind->windspeed_north, ports.wind->windspeed_east};
    if (!is_armed_) {
        ground_ = altitude_;
    } else if (ports.home && ports.home->valid_lpos) {
        ground_ = -ports.home->z;
    }
}

float FwGuidance::airspeed_or_trim(const FwGuidancePorts& ports) const {
    const bool is_known = ports.airspeed && math::is_finite(ports.airspeed->true_airspeed_m_s);
    return is_known ? ports.airspeed->true_airspeed_m_s : ports.params->trim_airspeed;
}

// Rate of heading towards a heading.
float FwGuidance::steer(float heading, float gain) const {
    return gain * math::wrap_pi(heading - heading_);
}

void FwGuidance::follow(const FwGuidancePorts& ports, const Path& path) {
    const PathPoint nearest = path.nearest(position_);
    lateral_ = kStraight;
    lateral_.lateral_acceleration = lateral_acceleration(nearest,
                                                         {.position = position_,
                                                          .velocity = velocity_,
                                                          .wind = wind_,
                                                          .airspeed = airspeed_or_trim(ports)},
                                                         gains_of(*ports.params));
    const float speed = math::max(velocity_.dot(nearest.tangent), 0.0F);
    setpoint_.position[0] = nearest.position.x();
    setpoint_.position[1] = nearest.position.y();
    setpoint_.velocity[0] = speed * nearest.tangent.x();
    setpoint_.velocity[1] = speed * nearest.tangent.y();
    setpoint_.yaw = bearing_of(nearest.tangent);
}

// --- goals ---

void FwGuidance::take_goal(const FwGuidancePorts& ports) {
    if (!ports.goal || (has_goal_ && ports.goal->number == goal_.number)) return;
    const GotoSetpoint before = goal_;
    const bool was_reached =
        has_goal_ && is_done_ && before.kind == GotoSetpoint::Kind::kPosition && !path_.is_circle();
    goal_ = *ports.goal;
    has_goal_ = true;
    is_done_ = is_take_off_ = false;
    const Vector2 place(goal_.position[0], goal_.position[1]);
    const float radius = ports.params->loiter_radius;
    using Kind = GotoSetpoint::Kind;
    switch (goal_.kind) {
        case Kind::kPosition: {
            const Vector2 from =
                was_reached ? Vector2(before.position[0], before.position[1]) : position_;
            path_ = Path::line(from, place, bearing_of(velocity_));
            wanted_altitude_ = -goal_.position[2];
            // What is nearer than the circle is round it: a climb or a descent on the spot.
            if (math::norm(Vector2(place - position_)) < radius)
                path_ = Path::circle(place, radius);
            break;
        }
        case Kind::kEight:  // circles, as many
        case Kind::kCircle:
            path_ =
                Path::circle(place, math::copysign(math::max(goal_.length, radius), goal_.laps));
            wanted_altitude_ = -goal_.position[2];
            break;
        case Kind::kLand:
            begin_landing(ports);
            break;
        default:  // stays here
            path_ = Path::circle(position_, radius);
            wanted_altitude_ = altitude_;
            is_done_ = true;
            break;
    }
    turned_ = 0.0F;
    bearing_from_centre_ = bearing_of(Vector2(position_ - path_.end()));
}

void FwGuidance::begin_landing(const FwGuidancePorts& ports) {
    const FwGuidanceParams& params = *ports.params;
    float heading = start_heading_;
    if (params.lands_into_wind && math::norm(wind_) > kWindCounts) {
        heading = bearing_of(Vector2(-wind_));
    }
    if (math::is_finite(goal_.heading)) heading = goal_.heading;
    const Vector2 place(goal_.position[0], goal_.position[1]);
    // On the side where the vehicle is.
    const float side = cross(unit(heading), Vector2(position_ - place));
    landing_ = {};
    landing_.begin(
        {.place = place,
         .heading = heading,
         .slope = params.landing_slope,
         .height = params.approach_height,
         .radius = math::copysign(params.loiter_radius, side),
         .flare_height = params.flare_height,
         .flare_sink = params.flare_sink,
         .ground_speed = math::max(params.landing_airspeed + wind_.dot(unit(heading)), kSlowest)});
    touchdown_heading_ = heading;
}

// Round a circle; more than half a turn in a step is none.
void FwGuidance::count_laps() {
    const float bearing = bearing_of(Vector2(position_ - path_.end()));
    turned_ += math::wrap_pi(bearing - bearing_from_centre_);
    bearing_from_centre_ = bearing;
}

// --- stages ---

void FwGuidance::stand() {
    lateral_ = kStraight;
    lateral_.yaw_rate = 0.0F;
    longitudinal_ = kFree;
    longitudinal_.pitch_direct = kTailDownPitch;
    longitudinal_.throttle_direct = 0.0F;
    start_ = position_;
    start_heading_ = heading_;
    touchdown_heading_ = heading_;
    in_stage_s_ = rotating_s_ = 0.0F;
}

void FwGuidance::roll(const FwGuidancePorts& ports, float dt) {
    const FwGuidanceParams& params = *ports.params;
    const bool has_sensor =
        ports.airspeed && math::is_finite(ports.airspeed->calibrated_airspeed_m_s);
    const float ground_speed = math::norm(velocity_);
    const float airspeed = has_sensor ? ports.airspeed->calibrated_airspeed_m_s : ground_speed;
    if (airspeed > kRotates * params.takeoff_airspeed) rotating_s_ += dt;
    const float time = math::max(params.takeoff_time, 0.1F);
    const float opened = math::clamp(in_stage_s_ / time, 0.0F, 1.0F);
    const float rotated = math::clamp(rotating_s_ / time, 0.0F, 1.0F);
    longitudinal_ = kFree;
    longitudinal_.throttle_direct = opened;
    longitudinal_.pitch_direct =
        params.runway_pitch + rotated * (params.takeoff_pitch - params.runway_pitch);
    lateral_ = kStraight;
    const float off = cross(unit(start_heading_), Vector2(position_ - start_));
    lateral_.yaw_rate =
        steer(start_heading_ - math::clamp(kLanePull * off, -0.2F, 0.2F), params.wheel_gain);
    // A pitot that is blocked, or a wheel that is stuck: it would run off the end.
    const bool is_too_long = math::norm(Vector2(position_ - start_)) > params.abort_length;
    if (altitude_ - ground_ > kIsOff) {
        stage_ = Stage::kClimbOut;
    } else if (is_too_long) {
        stage_ = Stage::kLanded;
    }
}

void FwGuidance::climb_out(const FwGuidancePorts& ports) {
    const FwGuidanceParams& params = *ports.params;
    follow(ports, Path::line(start_, start_ + unit(start_heading_), start_heading_));
    const float height = altitude_ - ground_;
    // Low, a steep bank is worse than a wrong course.
    const float most = kGravity * math::tan(math::clamp(0.1F + 0.05F * height, 0.0F, 0.7F));
    lateral_.lateral_acceleration = math::clamp(lateral_.lateral_acceleration, -most, most);
    longitudinal_ = kFree;
    longitudinal_.altitude = wanted_altitude_;
    longitudinal_.throttle_direct = 1.0F;
    const bool is_slow =
        ports.airspeed && ports.airspeed->calibrated_airspeed_m_s < 1.1F * params.takeoff_airspeed;
    if (height < 0.5F * params.clearance && is_slow) {
        longitudinal_.pitch_direct = params.takeoff_pitch;
    }
    setpoint_.position[2] = -wanted_altitude_;
    if (height < math::min(params.clearance, wanted_altitude_ - ground_)) return;
    stage_ = Stage::kFlight;
    path_ = Path::line(start_, start_ + unit(start_heading_), start_heading_);
}

void FwGuidance::fly_goal(const FwGuidancePorts& ports) {
    const FwGuidanceParams& params = *ports.params;
    follow(ports, path_);
    longitudinal_ = kFree;
    longitudinal_.altitude = wanted_altitude_;
    if (goal_.kind != GotoSetpoint::Kind::kStop && goal_.max_horizontal_speed > 0.0F) {
        longitudinal_.equivalent_airspeed = goal_.max_horizontal_speed;
    }
    setpoint_.position[2] = -wanted_altitude_;
    const float off = math::abs(altitude_ - wanted_altitude_);
    const bool is_at_height = off < params.height_acceptance;
    const bool is_figure =
        goal_.kind == GotoSetpoint::Kind::kCircle || goal_.kind == GotoSetpoint::Kind::kEight;
    if (is_figure) {
        count_laps();
        is_done_ = is_done_ || math::abs(turned_) >= math::kTwoPi<float> * math::abs(goal_.laps);
        return;
    }
    if (is_done_) {
        // It is not taken further: round the place.
        const Vector2 place(goal_.position[0], goal_.position[1]);
        const bool waits = !path_.is_circle() && (is_take_off_ || path_.left(position_) < 0.0F);
        if (waits) path_ = Path::circle(place, params.loiter_radius);
        return;
    }
    if (path_.is_circle()) {
        is_done_ = is_at_height;
        return;
    }
    // A take-off leads straight on.
    if (is_take_off_) {
        is_done_ = is_at_height;
        return;
    }
    if (path_.left(position_) > turn_distance(math::norm(velocity_))) return;
    if (is_at_height) {
        is_done_ = true;
    } else {
        path_ = Path::circle(Vector2(goal_.position[0], goal_.position[1]), params.loiter_radius);
    }
}

void FwGuidance::land(const FwGuidancePorts& ports, float dt) {
    const FwGuidanceParams& params = *ports.params;
    const float height = altitude_ - ground_;
    landing_.update(
        {.position = position_, .velocity = velocity_, .height = height, .climb = climb_}, dt);
    follow(ports, landing_.path());
    const bool is_slow = ports.airspeed && ports.airspeed->calibrated_airspeed_m_s <
                                               kRotates * params.takeoff_airspeed;
    longitudinal_ = kFree;
    longitudinal_.equivalent_airspeed = params.landing_airspeed;
    longitudinal_.altitude = ground_ + landing_.height_at(position_);
    setpoint_.position[2] = -longitudinal_.altitude;
    switch (landing_.phase()) {
        case Landing::Phase::kCircle:
            return;
        case Landing::Phase::kSlope: {
            // The slope itself, fed forward: its height alone would be followed late.
            const float slope_rate = -math::norm(velocity_) * math::tan(landing_.plan().slope);
            const bool is_on_slope = landing_.height_at(position_) < landing_.plan().height;
            if (is_on_slope) {
                const float off = longitudinal_.altitude - altitude_;
                longitudinal_.height_rate = slope_rate + math::clamp(0.5F * off, -1.0F, 1.5F);
                longitudinal_.altitude = kNaN;
            }
            break;
        }
        case Landing::Phase::kFlare:
            longitudinal_.altitude = kNaN;
            longitudinal_.height_rate = -landing_.sink_at(height);
            // From here on it may only sink: without power it cannot float along in gusts.
            if (height < kPowerless) longitudinal_.throttle_direct = 0.0F;
            if (height < kPowerless && is_slow) stage_ = Stage::kLanded;
            if (sinks_s_ > 0.0F) longitudinal_.pitch_direct = kFlarePitch;
            break;
        case Landing::Phase::kRoll:
            stage_ = Stage::kLanded;
            break;
    }
    const float most = kGravity * math::tan(math::clamp(0.06F + 0.04F * height, 0.06F, 0.6F));
    lateral_.lateral_acceleration = math::clamp(lateral_.lateral_acceleration, -most, most);
}

void FwGuidance::descend() {
    const bool is_low = altitude_ - ground_ < kLow;
    lateral_ = kStraight;
    if (!is_low) lateral_.lateral_acceleration = kGravity * math::tan(kGentleBank);
    longitudinal_ = kFree;
    longitudinal_.throttle_direct = 0.0F;
    if (is_low) longitudinal_.pitch_direct = kFlarePitch;
}

// Far below its height, and sinking further though it wants to climb.
void FwGuidance::watch_height(float dt) {
    const float wanted = longitudinal_.altitude;
    const bool cannot =
        stage_ == Stage::kFlight && wanted - altitude_ > kFarBelow && climb_ < -kSinks;
    if (cannot) {
        sinks_s_ = math::min(sinks_s_ + dt, kLongest_s);
    } else if (climb_ > 0.0F || stage_ != Stage::kFlight) {
        sinks_s_ = 0.0F;
    }
}

void FwGuidance::fly_by_sticks(const FwGuidancePorts& ports) {
    const FwGuidanceParams& params = *ports.params;
    lateral_ = kStraight;
    longitudinal_ = kFree;
    longitudinal_.height_rate = 0.0F;
    if (!ports.sticks || !ports.sticks->valid) return;
    const ManualControlSetpoint& sticks = *ports.sticks;
    lateral_.lateral_acceleration = kGravity * math::tan(params.stick_roll * sticks.roll);
    longitudinal_.height_rate = -params.stick_climb * sticks.pitch;
    longitudinal_.equivalent_airspeed =
        params.trim_airspeed + 0.3F * params.trim_airspeed * sticks.throttle;
}

void FwGuidance::fly(const FwGuidancePorts& ports, float dt) {
    if (nav_state_ == Nav::kDescend) return descend();
    if (!follows_goals(nav_state_) || !has_goal_) return fly_by_sticks(ports);
    if (goal_.kind == GotoSetpoint::Kind::kLand) return land(ports, dt);
    fly_goal(ports);
}

void FwGuidance::step(FwGuidancePorts& ports) {
    if (!ports.position) return;
    const float dt = seconds_since_last(last_us_, ports.now, kShortestStep, kLongestStep);
    const bool armed =
        ports.status && ports.status->arming_state == VehicleStatus::ArmingState::kArmed;
    if (armed && !is_armed_) has_goal_ = false;
    is_armed_ = armed;
    if (ports.status) nav_state_ = ports.status->nav_state;
    take_inputs(ports);
    setpoint_ = kNoSetpoint;
    in_stage_s_ += dt;

    if (!armed) stage_ = Stage::kGround;
    if (armed && follows_goals(nav_state_)) {
        take_goal(ports);
    } else {
        has_goal_ = false;
    }
    const bool wants_up = has_goal_ && goal_.kind == GotoSetpoint::Kind::kPosition &&
                          wanted_altitude_ > ground_ + kAbove && nav_state_ != Nav::kReturn;
    const bool stands = ports.land && ports.land->landed;
    switch (stage_) {
        case Stage::kGround:
            stand();
            is_take_off_ = armed && wants_up;
            if (is_take_off_) stage_ = Stage::kRoll;
            if (armed && !stands && altitude_ - ground_ > kIsOff) stage_ = Stage::kFlight;
            break;
        case Stage::kRoll:
            if (!wants_up) stage_ = Stage::kLanded;
            roll(ports, dt);
            break;
        case Stage::kClimbOut:
            climb_out(ports);
            if (!follows_goals(nav_state_)) stage_ = Stage::kFlight;
            break;
        case Stage::kFlight:
            fly(ports, dt);
            break;
        case Stage::kLanded: {
            const float off_heading = stands ? heading_ : touchdown_heading_;
            lateral_ = kStraight;
            lateral_.yaw_rate = steer(off_heading, ports.params->wheel_gain);
            longitudinal_ = kFree;
            longitudinal_.throttle_direct = 0.0F;
            const bool is_slow = math::norm(Vector2(velocity_ - wind_)) < kSlowRoll;
            longitudinal_.pitch_direct = is_slow ? kTailDownPitch : kRollPitch;
            break;
        }
    }
    watch_height(dt);
    ports.lateral.publish([&] { return lateral_; });
    ports.longitudinal.publish([&] { return longitudinal_; });
    ports.setpoint.publish([&] { return setpoint_; });
    ports.progress.publish([&] {
        return TrajectoryProgress{
            .goal = goal_.number, .is_done = has_goal_ && is_done_, .lags_for = sinks_s_};
    });
}

}  // namespace stator::apps::fw_guidance
