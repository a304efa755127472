// Goals of take-off, return and landing; what all modes share.
#include "navigator.hpp"

#include "stator/elapsed.hpp"

namespace stator::apps::navigator {

using math::Vector3;

namespace {

constexpr float kNaN = math::canonical_nan<float>();
constexpr float kShortestStep = 1e-3F;
constexpr float kLongestStep = 1.0F;
// The way to a nearer place says nothing of where to look.
constexpr float kLooksFrom = 1.0F;  // m
// A descent that gains no height for so long is blocked, or cannot reach its place: it goes on.
constexpr float kSinks = 0.2F;  // m
constexpr float kPatience_s = 5.0F;
// Below the fence's ceiling, so that noise does not reach it.
constexpr float kBelowCeiling = 0.9F;
constexpr float kLowestClimb = 0.5F;  // m, of a take-off
// Laps of an orbit until it begins again: so its time stays small.
constexpr float kLaps = 50.0F;

}  // namespace

void Navigator::take_inputs(const NavigatorPorts& ports) {
    if (ports.position) {
        const VehicleLocalPosition& p = *ports.position;
        if (p.xy_valid) position_N_.head<2>() << p.x, p.y;
        if (p.z_valid) position_N_.z() = p.z;
        heading_ = p.heading;
    }
    if (!is_armed_) {
        home_N_ = position_N_;
    } else if (ports.home) {
        home_N_ = Vector3<float>(ports.home->x, ports.home->y, ports.home->z);
    }
    if (ports.position) frame_.update(*ports.position, home_N_);
    if (is_armed_ && home_N_.z() - position_N_.z() > kHasLeftGround) has_left_ground_ = true;
    has_arrived_ =
        ports.progress && ports.progress->goal == goal_.number && ports.progress->is_done;
}

// --- goals ---

void Navigator::start(GotoSetpoint::Kind kind) {
    ++goal_.number;
    goal_.kind = kind;
    has_arrived_ = false;
}

void Navigator::go(const Vector3<float>& position_N, float heading,
                   const Sequence::Speeds& speeds) {
    goal_.position = math::to_array(position_N);
    goal_.heading = heading;
    goal_.max_horizontal_speed = speeds.horizontal;
    goal_.max_vertical_speed = position_N.z() < position_N_.z() ? speeds.climb : speeds.descent;
    start(GotoSetpoint::Kind::kPosition);
}

float Navigator::heading_to(const Vector3<float>& position_N) const {
    const Vector3<float> way = position_N - position_N_;
    if (math::norm(way.head<2>()) < kLooksFrom) return goal_.heading;
    return math::atan2(way.y(), way.x());
}

void Navigator::finish(Nav next) {
    is_finished_ = true;
    next_ = next;
}

// --- modes ---

// The landing of a mission or a return keeps its place; a mission that waits does so in hold.
void Navigator::begin_mode() {
    const bool follows = is_finished_ && next_ == nav_state_;
    if (!follows || nav_state_ != Nav::kLand) land_N_.setConstant(kNaN);
    if (!follows || nav_state_ == Nav::kHold) speeds_ = {};
    waits_ = waits_ && follows && nav_state_ == Nav::kHold;
    phase_ = 0;
    in_phase_s_ = 0.0F;
    is_finished_ = false;
    orbit_.is_on = false;
    goal_.heading = kNaN;
    start(GotoSetpoint::Kind::kStop);
    if (nav_state_ != Nav::kMission) return;
    // A mission goes on with the whole of the item where it was left; one that was over begins
    // again.
    if (is_over_) sequence_.restart();
    is_over_ = false;
    sequence_.go_back_to_place();
}

// On the ground the flight that follows begins with it.
void Navigator::go_on_with(unsigned item) {
    if (!is_armed_) first_item_ = item;
    is_over_ = false;
    sequence_.go_on_with(item);
    if (nav_state_ != Nav::kMission) return;
    phase_ = 0;
    in_phase_s_ = 0.0F;
}

void Navigator::take_command(const NavigatorPorts& ports) {
    if (!ports.command.is_new()) return;
    const VehicleCommand& command = *ports.command;
    using Action = VehicleCommand::Action;
    if (command.action == Action::kSetItem) return go_on_with(command.item);
    const bool is_takeoff = command.action == Action::kSetMode &&
                            command.nav_state == static_cast<uint8_t>(Nav::kTakeoff);
    if (is_takeoff) takeoff_z_ = command.position[2];
    if (nav_state_ != Nav::kHold) return;
    if (command.action == Action::kOrbit) begin_orbit(command);
    if (command.action != Action::kGo) return;
    orbit_.is_on = false;
    go(place_of(command), command.heading, {});
}

// What is not given stays where the vehicle is.
Vector3<float> Navigator::place_of(const VehicleCommand& command) const {
    const auto or_here = [](float wish, float here) { return math::is_finite(wish) ? wish : here; };
    return {or_here(command.position[0], position_N_.x()),
            or_here(command.position[1], position_N_.y()),
            or_here(command.position[2], position_N_.z())};
}

// First to the nearest place of the circle.
void Navigator::begin_orbit(const VehicleCommand& command) {
    orbit_ = {.is_on = true,
              .faces_centre = command.faces_centre,
              .centre_N = place_of(command),
              .radius = command.radius};
    const Vector3<float> out = position_N_ - orbit_.centre_N;
    const math::SinCos<float> bearing = math::sincos(math::atan2(out.y(), out.x()));
    const float radius = math::abs(orbit_.radius);
    const Vector3<float> begin_N =
        orbit_.centre_N + Vector3<float>(radius * bearing.cos, radius * bearing.sin, 0.0F);
    go(begin_N, kNaN, {.horizontal = command.speed});
}

void Navigator::advance_orbit() {
    if (has_arrived_) {
        goal_.position = math::to_array(orbit_.centre_N);
        goal_.length = math::abs(orbit_.radius);
        goal_.laps = orbit_.radius < 0.0F ? -kLaps : kLaps;
        start(GotoSetpoint::Kind::kCircle);
    }
    if (orbit_.faces_centre) goal_.heading = heading_to(orbit_.centre_N);
}

void Navigator::advance(const NavigatorPorts& ports, float dt) {
    switch (nav_state_) {
        case Nav::kTakeoff:
            return advance_takeoff(ports);
        case Nav::kMission:
            return advance_mission(ports, dt);
        case Nav::kReturn:
            return advance_return(ports);
        case Nav::kLand:
            if (has_stopped_sinking(dt)) has_arrived_ = true;
            return advance_landing(ports);
        case Nav::kHold: {
            if (orbit_.is_on) return advance_orbit();
            const float most = ports.params->wait_limit;
            if (waits_ && most > 0.0F && in_phase_s_ >= most) finish(Nav::kReturn);
            return;
        }
        default:
            return;
    }
}

void Navigator::advance_takeoff(const NavigatorPorts& ports) {
    if (phase_ == 0 && in_phase_s_ >= ports.params->spool_up_time) {
        const float usual_z = home_N_.z() - ports.params->takeoff_height;
        // Stations send zero for a height that they do not care about; where that is below the
        // ground, the vehicle climbs to the usual one.
        const bool is_above = takeoff_z_ < position_N_.z() - kLowestClimb;
        const float z = is_above ? takeoff_z_ : usual_z;
        go({position_N_.x(), position_N_.y(), math::min(z, position_N_.z())}, kNaN, {});
        phase_ = 1;
    } else if (phase_ == 1 && has_arrived_) {
        finish(Nav::kHold);
    }
}

// Home or a rally point, whichever is nearest.
void Navigator::choose_return_place() {
    return_N_ = home_N_;
    const auto away2 = [this](const Vector3<float>& place_N) {
        const Vector3<float> way = place_N - position_N_;
        return way.x() * way.x() + way.y() * way.y();
    };
    for (unsigned i = 0; i < rally_read_; ++i) {
        if (away2(rally_N_[i]) < away2(return_N_)) return_N_ = rally_N_[i];
    }
    land_N_ = return_N_;
}

// Phase 0: begins; 1: up; 2: there; then it lands.
void Navigator::advance_return(const NavigatorPorts& ports) {
    if (phase_ == 0) {
        choose_return_place();
        const Vector3<float> way = return_N_ - position_N_;
        const bool is_there = math::norm(way.head<2>()) < ports.params->home_radius;
        const float ceiling = fence_.limits(usual_fence(ports)).height;
        float height = math::max(ports.params->return_height, home_N_.z() - return_N_.z());
        if (ceiling > 0.0F) height = math::min(height, kBelowCeiling * ceiling);
        const float z = math::min(position_N_.z(), home_N_.z() - height);
        phase_ = 1;
        if (!is_there) return go({position_N_.x(), position_N_.y(), z}, kNaN, speeds_);
        has_arrived_ = true;
    }
    if (phase_ == 1 && has_arrived_) {
        const Vector3<float> above_N(return_N_.x(), return_N_.y(), position_N_.z());
        phase_ = 2;
        return go(above_N, heading_to(above_N), speeds_);
    }
    if (phase_ == 2 && has_arrived_) finish(Nav::kLand);
}

bool Navigator::has_stopped_sinking(float dt) {
    if (phase_ != 1 || position_N_.z() > lowest_ + kSinks) {
        lowest_ = position_N_.z();
        since_lowest_s_ = 0.0F;
    }
    since_lowest_s_ += dt;
    return phase_ == 1 && since_lowest_s_ > kPatience_s;
}

// Phase 0: stops; 1: down fast; 2: down slowly, until the commander disarms.
void Navigator::advance_landing(const NavigatorPorts& ports) {
    const bool has_waited = phase_ == 0 && in_phase_s_ > kPatience_s;
    if ((!has_arrived_ && !has_waited) || phase_ == 2) return;
    ++phase_;
    if (phase_ == 1) {
        const float z = home_N_.z() - ports.params->landing_height;
        // From where the setpoint rests, which is where the last goal was if that was reached.
        const float away =
            math::norm(math::vector(goal_.position).head<2>() - position_N_.head<2>());
        const bool is_near = away < math::max(kLooksFrom, ports.params->near_enough);
        const Vector3<float> here = is_near ? math::vector(goal_.position) : position_N_;
        if (position_N_.z() < z) return go({here.x(), here.y(), z}, kNaN, speeds_);
        goal_.position = math::to_array(here);
    }
    phase_ = 2;
    start(GotoSetpoint::Kind::kLand);
}

void Navigator::step(NavigatorPorts& ports) {
    const float dt = seconds_since_last(last_us_, ports.now, kShortestStep, kLongestStep);
    in_phase_s_ += dt;
    const bool armed =
        ports.status && ports.status->arming_state == VehicleStatus::ArmingState::kArmed;
    const bool begins = armed && (!is_armed_ || ports.status->nav_state != nav_state_);
    if (armed && !is_armed_) {
        sequence_.restart();
        sequence_.go_on_with(first_item_);
        first_item_ = 0;
        is_over_ = false;
        has_left_ground_ = false;
        reached_ = -1;
        is_finished_ = false;
    }
    is_armed_ = armed;
    take_inputs(ports);
    reader_.begin(ports);
    if (begins) {
        nav_state_ = ports.status->nav_state;
        begin_mode();
    }
    take_command(ports);
    if (armed && !is_finished_) advance(ports, dt);
    read_plans(ports);
    reader_.finish(ports, dt);
    watch_fence(ports);
    publish(ports);
}

void Navigator::publish(NavigatorPorts& ports) {
    const Fault fault = this->fault(ports);
    const uint16_t count = ports.mission ? ports.mission->count : 0;
    ports.goal.publish([&] { return goal_; });
    ports.result.publish([&] {
        return MissionResult{.mission_id = ports.mission ? ports.mission->mission_id : 0,
                             .seq_reached = reached_,
                             .seq_current = static_cast<uint16_t>(sequence_.current()),
                             .seq_total = count,
                             .fault_seq = static_cast<uint16_t>(fault_item_),
                             .valid = fault == Fault::kNone,
                             .finished = is_finished_,
                             .nav_state = static_cast<uint8_t>(nav_state_),
                             .next_nav_state = static_cast<uint8_t>(next_),
                             .fault = fault,
                             .waits = waits_,
                             .land_x = land_N_.x(),
                             .land_y = land_N_.y()};
    });
}

}  // namespace stator::apps::navigator
