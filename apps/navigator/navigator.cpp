// Goals of take-off, mission, return and landing.
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
// A place where the vehicle rests is reached when it is this near, or after this time there.
constexpr float kNearEnough = 0.5F;  // m
constexpr float kSettled_s = 4.0F;

}  // namespace

void Navigator::take_inputs(const NavigatorPorts& ports) {
    if (ports.position) {
        const VehicleLocalPosition& p = *ports.position;
        if (p.xy_valid) position_N_.head<2>() << p.x, p.y;
        if (p.z_valid) position_N_.z() = p.z;
    }
    if (ports.home) home_ = *ports.home;
    has_arrived_ =
        ports.progress && ports.progress->goal == goal_.number && ports.progress->is_done;
    if (!ports.mission || !ports.position) {
        mission_is_valid_ = false;
        return;
    }
    // On the ground home is here.
    const Eigen::Vector2f here_N = position_N_.head<2>();
    const Eigen::Vector2f home_N = is_armed_ ? Eigen::Vector2f(home_.x, home_.y) : here_N;
    origin_N_ = origin_N(*ports.mission, *ports.position, home_N);
    mission_is_valid_ = is_flyable(*ports.mission, origin_N_, home_N, ports.params->farthest);
}

// --- goals ---

void Navigator::start(GotoSetpoint::Kind kind) {
    ++goal_.number;
    goal_.kind = kind;
    has_arrived_ = false;
}

void Navigator::go(const Vector3<float>& position_N, float heading, float speed) {
    goal_.position = math::to_array(position_N);
    goal_.heading = heading;
    goal_.max_horizontal_speed = speed;
    goal_.max_vertical_speed = kNaN;
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

void Navigator::begin_mode(const NavigatorPorts& ports) {
    phase_ = 0;
    in_phase_s_ = 0.0F;
    is_finished_ = false;
    goal_.heading = kNaN;
    start(GotoSetpoint::Kind::kStop);
    // A mission goes on with the whole of the item where it was left; one that was over begins
    // again.
    if (ports.mission && current_ >= ports.mission->count) current_ = 0;
}

void Navigator::advance(const NavigatorPorts& ports) {
    switch (nav_state_) {
        case Nav::kTakeoff:
            return advance_takeoff(ports);
        case Nav::kMission:
            return advance_mission(ports);
        case Nav::kReturn:
            return advance_return(ports);
        case Nav::kLand:
            return advance_landing(ports);
        default:
            return;
    }
}

void Navigator::advance_takeoff(const NavigatorPorts& ports) {
    if (phase_ == 0 && in_phase_s_ >= ports.params->spool_up_time) {
        const float z = home_.z - ports.params->takeoff_height;
        go({position_N_.x(), position_N_.y(), math::min(z, position_N_.z())}, kNaN, kNaN);
        phase_ = 1;
    } else if (phase_ == 1 && has_arrived_) {
        finish(Nav::kHold);
    }
}

Item Navigator::item(const NavigatorPorts& ports) const {
    return item_at(*ports.mission, current_, origin_N_, home_.z);
}

void Navigator::begin_item(const NavigatorPorts& ports) {
    const Item next = item(ports);
    phase_ = 1;
    in_phase_s_ = 0.0F;
    switch (next.kind) {
        case ItemKind::kTakeoff:
            return go({position_N_.x(), position_N_.y(), next.position_N.z()}, kNaN, kNaN);
        case ItemKind::kReturn:
            return finish(Nav::kReturn);
        default: {
            const bool looks = math::is_finite(next.heading) && next.kind != ItemKind::kEight;
            return go(next.position_N, looks ? next.heading : heading_to(next.position_N),
                      next.speed);
        }
    }
}

// A stop is reached when the setpoint rests there and the vehicle is near, too, or has had the
// time; without a stop, when the vehicle is near.
bool Navigator::item_is_reached(const Item& item) const {
    const float away = math::norm(item.position_N - position_N_);
    const bool passes = item.kind == ItemKind::kWaypoint && item.hold == 0.0F;
    if (passes) return away < item.radius;
    if (item.kind == ItemKind::kTakeoff) return has_arrived_;
    return has_arrived_ && (away < kNearEnough || in_phase_s_ > kSettled_s);
}

// Phase 0: an item begins; 1: on the way; 2: there.
void Navigator::advance_mission(const NavigatorPorts& ports) {
    if (!ports.mission || !mission_is_valid_ || is_finished_) return;
    // A shorter one may have taken its place in flight.
    if (current_ >= ports.mission->count) return finish(Nav::kHold);
    if (phase_ == 0) {
        const bool on_ground = current_ == 0 && reached_ < 0;
        if (on_ground && in_phase_s_ < ports.params->spool_up_time) return;
        return begin_item(ports);
    }
    const Item now = item(ports);
    if (phase_ == 1) {
        if (!has_arrived_) in_phase_s_ = 0.0F;
        if (!item_is_reached(now)) return;
        phase_ = 2;
        in_phase_s_ = 0.0F;
        if (now.kind == ItemKind::kEight) {
            goal_.heading = math::is_finite(now.heading) ? now.heading : 0.0F;
            goal_.length = now.radius;
            goal_.laps = now.hold;
            start(GotoSetpoint::Kind::kEight);
            return;
        }
    }
    const bool is_over = now.kind == ItemKind::kEight ? has_arrived_ : in_phase_s_ >= now.hold;
    if (!is_over) return;
    reached_ = static_cast<int>(current_);
    if (now.kind == ItemKind::kLand) return finish(Nav::kLand);
    ++current_;
    phase_ = 0;
    if (current_ >= ports.mission->count) return finish(Nav::kHold);
    begin_item(ports);
}

// Phase 0: begins; 1: up; 2: home; then it lands.
void Navigator::advance_return(const NavigatorPorts& ports) {
    const Vector3<float> home_N(home_.x, home_.y, home_.z);
    if (phase_ == 0) {
        const bool is_home =
            math::norm(home_N.head<2>() - position_N_.head<2>()) < ports.params->home_radius;
        const float z = math::min(position_N_.z(), home_N.z() - ports.params->return_height);
        phase_ = 1;
        if (!is_home) return go({position_N_.x(), position_N_.y(), z}, kNaN, kNaN);
        has_arrived_ = true;
    }
    if (phase_ == 1 && has_arrived_) {
        const Vector3<float> above_N(home_N.x(), home_N.y(), position_N_.z());
        phase_ = 2;
        return go(above_N, heading_to(above_N), kNaN);
    }
    if (phase_ == 2 && has_arrived_) finish(Nav::kLand);
}

// Phase 0: stops; 1: down fast; 2: down slowly, until the commander disarms.
void Navigator::advance_landing(const NavigatorPorts& ports) {
    if (!has_arrived_ || phase_ == 2) return;
    ++phase_;
    const float z = home_.z - ports.params->landing_height;
    if (phase_ == 1 && position_N_.z() < z) {
        // From where the setpoint rests, which is where the last goal was if that was reached.
        const bool is_near =
            math::norm(math::vector(goal_.position).head<2>() - position_N_.head<2>()) < kLooksFrom;
        const Vector3<float> here = is_near ? math::vector(goal_.position) : position_N_;
        return go({here.x(), here.y(), z}, kNaN, kNaN);
    }
    phase_ = 2;
    start(GotoSetpoint::Kind::kLand);
}

void Navigator::step(NavigatorPorts& ports) {
    in_phase_s_ += seconds_since_last(last_us_, ports.now, kShortestStep, kLongestStep);
    take_inputs(ports);
    const bool armed =
        ports.status && ports.status->arming_state == VehicleStatus::ArmingState::kArmed;
    if (armed && !is_armed_) {
        current_ = 0;
        reached_ = -1;
    }
    const bool begins = armed && (!is_armed_ || ports.status->nav_state != nav_state_);
    is_armed_ = armed;
    if (begins) {
        nav_state_ = ports.status->nav_state;
        begin_mode(ports);
    }
    if (armed && !is_finished_) advance(ports);
    const uint16_t count = ports.mission ? ports.mission->count : 0;
    ports.goal.publish([&] { return goal_; });
    ports.result.publish([&] {
        return MissionResult{.seq_reached = reached_,
                             .seq_current = static_cast<uint16_t>(current_),
                             .seq_total = count,
                             .valid = mission_is_valid_,
                             .finished = is_finished_,
                             .nav_state = static_cast<uint8_t>(nav_state_),
                             .next_nav_state = static_cast<uint8_t>(next_)};
    });
}

}  // namespace stator::apps::navigator
