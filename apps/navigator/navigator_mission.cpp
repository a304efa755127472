// The mission: on the way to a place, there, and on to the next one.
#include "navigator.hpp"

namespace stator::apps::navigator {

using math::Vector3;

namespace {

constexpr float kNaN = math::canonical_nan<float>();
// A place where the vehicle rests is reached when it is near enough, or after this time there.
constexpr float kSettled_s = 4.0F;
constexpr float kHasDirection = 0.5F;    // m: from nearer, a circle begins anywhere
constexpr float kShortestCircle = 0.5F;  // m, of radius

}  // namespace

// Phase 0: the next item begins; 1: on the way; 2: there; 3: up first, from the ground.
void Navigator::advance_mission(const NavigatorPorts& ports, float dt) {
    if (!ports.mission || ports.mission->count == 0) return;
    const Mission& mission = *ports.mission;
    if (mission.mission_id != flown_id_) sequence_.forget();
    flown_id_ = mission.mission_id;
    const Situation situation{
        .before_N = position_N_, .position_N = position_N_, .heading = heading_, .dt = dt};
    if (phase_ == 0) {
        if (!has_left_ground_ && in_phase_s_ < ports.params->spool_up_time) return;
        return take_next(mission, situation);
    }
    if (phase_ == 3) {
        if (!has_arrived_) return;
        has_left_ground_ = true;
        return begin_item();
    }
    if (phase_ == 1) {
        if (!has_arrived_) in_phase_s_ = 0.0F;
        sequence_.do_beside(reader_, mission.mission_id, frame_, situation, false);
        if (sequence_.take_speed_change()) begin_item();
        look();
        if (!is_at_place(ports.params->near_enough)) return;
        phase_ = 2;
        in_phase_s_ = 0.0F;
        // One that lasts counts when it is reached, the others when they are over.
        if (sequence_.item().kind == ItemKind::kLoiterUnlimited) {
            reached_ = static_cast<int>(sequence_.current());
        }
        begin_figure(sequence_.item());
    }
    look();
    if (!is_over()) return;
    sequence_.do_beside(reader_, mission.mission_id, frame_, situation, true);
    leave_item();
    if (!is_finished_) take_next(mission, situation);
}

void Navigator::take_next(const Mission& mission, Situation situation) {
    if (checked_id_ != mission.mission_id) return;
    if (sequence_.has_place()) situation.before_N = sequence_.item().position_N;
    switch (sequence_.take(reader_, mission.mission_id, mission.count, frame_, situation)) {
        case Sequence::Next::kPlace:
            starved_s_ = 0.0F;
            return begin_item();
        case Sequence::Next::kMissing:
            starved_s_ += situation.dt;
            return;
        case Sequence::Next::kOver:
            is_over_ = true;
            return wait_here();
        case Sequence::Next::kWaiting:
            return;
    }
}

void Navigator::begin_item() {
    const Item& item = sequence_.item();
    static_cast<void>(sequence_.take_speed_change());
    phase_ = 1;
    in_phase_s_ = 0.0F;
    speeds_ = sequence_.speeds();
    if (item.kind == ItemKind::kReturn) {
        return has_left_ground_ ? finish(Nav::kReturn) : wait_here();
    }
    if (!has_left_ground_ && item.kind == ItemKind::kDelay) {
        phase_ = 2;
        return;
    }
    if (!has_left_ground_ && item.kind != ItemKind::kTakeoff) return climb_first();
    Sequence::Speeds speeds = sequence_.speeds();
    Vector3<float> place_N = item.position_N;
    switch (item.kind) {
        case ItemKind::kTakeoff:
            place_N.head<2>() = position_N_.head<2>();
            return go(place_N, kNaN, speeds);
        case ItemKind::kConditionChangeAltitude:
            if (item.param[0] > 0.0F) speeds.climb = speeds.descent = item.param[0];
            return go(place_N, goal_.heading, speeds);
        case ItemKind::kContinueAndChangeAltitude:
        case ItemKind::kDelay:
            return go(place_N, goal_.heading, speeds);
        case ItemKind::kLoiterTurns: {
            // To the nearest point of the circle.
            const Vector3<float> from = position_N_ - place_N;
            const float away = math::norm(from.head<2>());
            const float radius = math::abs(item.param[2]);
            const Vector3<float> side = away > kHasDirection
                                            ? Vector3<float>(from * (radius / away))
                                            : Vector3<float>(radius, 0.0F, 0.0F);
            place_N.head<2>() += side.head<2>();
            break;
        }
        case ItemKind::kLand:
            land_N_ = place_N;
            break;
        default:
            break;
    }
    const float heading = heading_of(item);
    go(place_N, math::is_finite(heading) ? heading : heading_to(place_N), speeds);
}

// A mission that does not begin with a take-off climbs to the height of its first place.
void Navigator::climb_first() {
    const float height = math::max(home_N_.z() - sequence_.item().position_N.z(), kHasLeftGround);
    go({position_N_.x(), position_N_.y(), home_N_.z() - height}, kNaN, sequence_.speeds());
    phase_ = 3;
}

// What follows the way to the place.
void Navigator::begin_figure(const Item& item) {
    if (item.kind == ItemKind::kEight) {
        goal_.heading = math::is_finite(item.param[3]) ? item.param[3] : 0.0F;
        goal_.length = 2.0F * item.param[0];
        goal_.laps = math::max(item.param[2], 1.0F);
        start(GotoSetpoint::Kind::kEight);
    }
    const float radius = math::abs(item.param[2]);
    if (item.kind == ItemKind::kLoiterTurns && radius >= kShortestCircle) {
        goal_.position = math::to_array(item.position_N);
        goal_.length = radius;
        goal_.laps = item.param[2] < 0.0F ? -item.param[0] : item.param[0];
        start(GotoSetpoint::Kind::kCircle);
    }
}

// A stop is reached when the setpoint rests there and the vehicle is near, too, or has had the
// time; without a stop, when the vehicle is near, or the same.
bool Navigator::is_at_place(float near_enough) const {
    const Item& item = sequence_.item();
    const float away = math::norm(math::vector(goal_.position) - position_N_);
    if (is_passed(item) && away < radius_of(item)) return true;
    if (item.kind == ItemKind::kTakeoff) return has_arrived_;
    return has_arrived_ && (away < near_enough || in_phase_s_ > kSettled_s);
}

bool Navigator::is_over() const {
    const Item& item = sequence_.item();
    switch (goal_.kind) {
        case GotoSetpoint::Kind::kEight:
        case GotoSetpoint::Kind::kCircle:
            return has_arrived_;
        default:
            return in_phase_s_ >= hold_of(item);
    }
}

void Navigator::leave_item() {
    const Item& item = sequence_.item();
    reached_ = static_cast<int>(sequence_.current());
    if (item.kind == ItemKind::kTakeoff) has_left_ground_ = true;
    if (item.kind == ItemKind::kLand) return finish(Nav::kLand);
    sequence_.arrive();
    phase_ = 0;
    if (!item.continues) wait_here();
}

// In hold, until the pilot wants something else, or the time for it is over.
void Navigator::wait_here() {
    waits_ = true;
    finish(Nav::kHold);
}

// At the region of interest; on a circle at its middle; else as a condition wants.
void Navigator::look() {
    if (goal_.kind == GotoSetpoint::Kind::kEight) return;
    if (sequence_.has_region()) {
        goal_.heading = heading_to(sequence_.region_N());
    } else if (math::is_finite(sequence_.heading())) {
        goal_.heading = sequence_.heading();
    } else if (goal_.kind == GotoSetpoint::Kind::kCircle) {
        goal_.heading = heading_to(math::vector(goal_.position));
    }
}

}  // namespace stator::apps::navigator
