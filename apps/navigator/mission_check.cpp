// Whether a mission can be flown.
#include "mission_check.hpp"

namespace stator::apps::navigator {

using math::Vector3;

namespace {

using Fault = MissionCheck::Fault;

// How far from its place an item leads: to the tips of an eight, to the far side of a circle.
float reach(const Item& item) {
    if (item.kind == ItemKind::kEight) return item.param[0];
    if (item.kind == ItemKind::kLoiterTurns) return math::abs(item.param[2]);
    return 0.0F;
}

bool has_good_values(const Item& item) {
    switch (item.kind) {
        case ItemKind::kWaypoint:
            return math::is_finite(hold_of(item)) && math::is_finite(radius_of(item));
        case ItemKind::kLoiterTime:
        case ItemKind::kDelay:
            return math::is_finite(item.param[0]) && item.param[0] >= 0.0F;
        case ItemKind::kLoiterTurns:
            return math::is_finite(item.param[0]) && math::is_finite(item.param[2]) &&
                   item.param[0] >= 0.0F;
        case ItemKind::kEight:
            return math::is_finite(item.param[0]) && math::is_finite(item.param[2]) &&
                   2.0F * item.param[0] >= kShortestEight;
        default:
            return true;
    }
}

}  // namespace

void MissionCheck::take(const RawItem& raw, unsigned count, const PlaceFrame& frame,
                        const Geofence& fence, const CheckLimits& limits) {
    fault_ = fault_of(raw, count, frame, fence, limits);
    if (fault_ == Fault::kNone) ++next_;
}

Fault MissionCheck::fault_of(const RawItem& raw, unsigned count, const PlaceFrame& frame,
                             const Geofence& fence, const CheckLimits& limits) {
    if (static_cast<ItemKind>(raw.command) == ItemKind::kJump) {
        const float target = raw.param[0];
        const bool is_good = target >= 0.0F && target < static_cast<float>(count) &&
                             target != static_cast<float>(next_) && math::is_finite(raw.param[1]);
        return is_good && ++jumps_ <= Sequence::kMaxJumps ? Fault::kNone : Fault::kBadJump;
    }
    if (is_done_at_once(raw.command) || is_condition(raw.command) || is_passed_by(raw.command)) {
        return Fault::kNone;
    }
    if (!is_flown(raw.command)) return Fault::kUnknownCommand;
    if (!is_frame_known(raw.frame)) return Fault::kUnknownFrame;
    const Item item = item_of(raw, frame, before_N_);
    if (item.kind == ItemKind::kReturn || item.kind == ItemKind::kDelay) return Fault::kNone;
    if (!math::is_finite(item.position_N.sum())) return Fault::kNoPosition;
    if (!has_good_values(item)) return Fault::kBadValue;
    const Fault fault = fault_of_place(item, fence, limits);
    if (fault != Fault::kNone) return fault;
    if (fence.is_left_between(before_N_, item.position_N, home_N_)) return Fault::kLeavesFence;
    before_N_ = item.position_N;
    return Fault::kNone;
}

Fault MissionCheck::fault_of_place(const Item& item, const Geofence& fence,
                                   const CheckLimits& limits) const {
    const float height = home_N_.z() - item.position_N.z();
    const bool may_be_low = item.kind == ItemKind::kLand;
    if (!may_be_low && !(height > 0.0F)) return Fault::kBelowHome;
    const float away =
        math::norm(Vector3<float>(item.position_N - home_N_).head<2>()) + reach(item);
    if (away > limits.farthest) return Fault::kTooFar;
    const FenceLimits own = fence.limits(limits.fence);
    if (own.radius > 0.0F && away > own.radius) return Fault::kTooFar;
    if (fence.breach(item.position_N, home_N_, limits.fence).is_too_high) return Fault::kTooHigh;
    return stays_inside(item, fence, limits) ? Fault::kNone : Fault::kOutsideFence;
}

// The place, and as far around it as the item leads: away from home, and in eight directions.
bool MissionCheck::stays_inside(const Item& item, const Geofence& fence,
                                const CheckLimits& limits) const {
    if (fence.breach(item.position_N, home_N_, limits.fence).any()) return false;
    const float far = reach(item);
    if (far == 0.0F) return true;
    const Vector3<float> from_home = item.position_N - home_N_;
    float direction = math::atan2(from_home.y(), from_home.x());
    for (unsigned i = 0; i < 8; ++i) {
        const math::SinCos<float> unit = math::sincos(direction);
        const Vector3<float> around(far * unit.cos, far * unit.sin, 0.0F);
        if (fence.breach(item.position_N + around, home_N_, limits.fence).any()) return false;
        direction += 0.25F * math::kPi<float>;
    }
    return true;
}

}  // namespace stator::apps::navigator
