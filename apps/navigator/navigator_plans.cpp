// The plans of the mission device: fence, rally points, and whether the mission can be flown.
#include "navigator.hpp"

namespace stator::apps::navigator {

using math::Vector3;

namespace {

// On the ground home moves with the estimate; further than this the mission is looked at again.
constexpr float kHomeMoved = 1.0F;  // m
// Without an item for so long the mission counts as lost.
constexpr float kLongestHunger_s = 2.0F;

}  // namespace

FenceLimits Navigator::usual_fence(const NavigatorPorts& ports) const {
    return {.radius = ports.params->fence_radius, .height = ports.params->fence_height};
}

// A place on Earth waits for the frame's, and so does a height above the sea.
bool Navigator::can_place(const RawItem& item) const {
    const bool is_above_sea = item.frame == Frame::kGlobal || item.frame == Frame::kGlobalInt;
    if (is_above_sea && math::is_finite(item.z) && !frame_.knows_sea()) return false;
    return item.frame == Frame::kLocal || !has_place(item) || !is_frame_known(item.frame) ||
           frame_.knows_earth();
}

// One after the other, as there is one window: the fence, the rally points, the mission.
void Navigator::read_plans(const NavigatorPorts& ports) {
    if (!ports.mission || !ports.position) return;
    const Mission& mission = *ports.mission;
    lacks_place_ = false;
    const bool is_new = mission.geofence_id != fence_id_ || mission.safe_points_id != rally_id_ ||
                        ports.position->ref_timestamp != frame_us_;
    if (is_new) {
        fence_id_ = mission.geofence_id;
        rally_id_ = mission.safe_points_id;
        frame_us_ = ports.position->ref_timestamp;
        fence_.clear();
        fence_fault_ = Fault::kNone;
        fence_read_ = rally_read_ = 0;
        checked_id_ = checking_id_ = 0;
    }
    if (read_fence(mission) && read_rally_points(mission)) check_mission(ports);
}

// Says whether all is there, good or bad.
bool Navigator::read_fence(const Mission& mission) {
    while (fence_read_ < mission.geofence_count) {
        const auto raw = reader_.item(ItemReader::List::kFence, fence_id_, fence_read_);
        if (!raw) return false;
        lacks_place_ = !can_place(*raw);
        if (lacks_place_) return false;
        ++fence_read_;
        const bool is_good = fence_.add(*raw, frame_);
        if (is_good && (fence_read_ < mission.geofence_count || fence_.is_whole())) continue;
        fence_fault_ = Fault::kBadFence;
        fence_read_ = mission.geofence_count;
    }
    return true;
}

bool Navigator::read_rally_points(const Mission& mission) {
    while (rally_read_ < mission.safe_points_count && rally_read_ < kMaxRallyPoints) {
        const auto raw = reader_.item(ItemReader::List::kRally, rally_id_, rally_read_);
        if (!raw) return false;
        lacks_place_ = !can_place(*raw);
        if (lacks_place_) return false;
        const Vector3<float> place_N = frame_.place(*raw, home_N_);
        if (!math::is_finite(place_N.sum())) fence_fault_ = Fault::kBadRallyPoint;
        rally_N_[rally_read_++] = place_N;
    }
    return true;
}

void Navigator::check_rally_points(const NavigatorPorts& ports) {
    for (unsigned i = 0; i < rally_read_ && verdict_ == Fault::kNone; ++i) {
        if (!fence_.breach(rally_N_[i], home_N_, usual_fence(ports)).any()) continue;
        verdict_ = Fault::kBadRallyPoint;
        fault_item_ = i;
    }
}

// As many items as there are in the window. The verdict before counts until the next one.
void Navigator::check_mission(const NavigatorPorts& ports) {
    const Mission& mission = *ports.mission;
    const uint32_t id = mission.mission_id;
    const bool has_moved =
        !is_armed_ && math::norm(Vector3<float>(home_N_ - check_.home_N())) > kHomeMoved;
    if (id == 0 || (checked_id_ == id && !has_moved && checking_id_ == 0)) return;
    if (checking_id_ != id) {
        check_ = MissionCheck(home_N_);
        checking_id_ = id;
    }
    const CheckLimits limits{.farthest = ports.params->farthest, .fence = usual_fence(ports)};
    while (check_.fault() == Fault::kNone && check_.next() < mission.count) {
        const auto raw = reader_.item(ItemReader::List::kMission, id, check_.next());
        if (!raw) return;
        lacks_place_ = !can_place(*raw);
        if (lacks_place_) return;
        check_.take(*raw, mission.count, frame_, fence_, limits);
    }
    verdict_ = check_.fault();
    fault_item_ = check_.next();
    checked_id_ = id;
    checking_id_ = 0;
    check_rally_points(ports);
}

Navigator::Fault Navigator::fault(const NavigatorPorts& ports) const {
    if (!ports.mission || ports.mission->count == 0) return Fault::kMissing;
    if (!ports.position) return Fault::kNoPosition;
    if (fence_fault_ != Fault::kNone) return fence_fault_;
    if (starved_s_ > kLongestHunger_s) return Fault::kUnread;
    if (checked_id_ == ports.mission->mission_id) return verdict_;
    // In the air it is looked at before its next item is flown.
    if (is_armed_) return Fault::kNone;
    return lacks_place_ ? Fault::kNoPosition : Fault::kUnread;
}

void Navigator::watch_fence(NavigatorPorts& ports) {
    Geofence::Breach breach;
    const bool is_known = ports.position && ports.position->xy_valid && ports.position->z_valid;
    if (is_known && is_armed_) breach = fence_.breach(position_N_, home_N_, usual_fence(ports));
    ports.fence.publish([&] {
        return GeofenceResult{.geofence_max_dist_triggered = breach.is_too_far,
                              .geofence_max_alt_triggered = breach.is_too_high,
                              .geofence_custom_fence_triggered = breach.is_outside};
    });
}

}  // namespace stator::apps::navigator
