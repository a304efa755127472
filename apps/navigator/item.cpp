// One item of a mission: what of it is flown, and where.
#include "item.hpp"

namespace stator::apps::navigator {

using math::Vector3;

namespace {

constexpr float kNaN = math::canonical_nan<float>();
constexpr float kDegree = math::kPi<float> / 180.0F;
constexpr float kForever_s = 1e9F;

float positive_or(float value, float fallback) {
    return value > 0.0F ? value : fallback;  // not a number is not above 0
}

ItemKind kind_of(uint16_t command) {
    const auto kind = static_cast<ItemKind>(command);
    switch (kind) {
        case ItemKind::kSplineWaypoint:
            return ItemKind::kWaypoint;
        case ItemKind::kVtolTakeoff:
            return ItemKind::kTakeoff;
        case ItemKind::kVtolLand:
            return ItemKind::kLand;
        case ItemKind::kRegionOfInterestNav:
            return ItemKind::kRegionOfInterest;
        default:
            return kind;
    }
}

bool changes_altitude(ItemKind kind) {
    return kind == ItemKind::kContinueAndChangeAltitude ||
           kind == ItemKind::kConditionChangeAltitude;
}

}  // namespace

Vector3<float> PlaceFrame::place(const RawItem& item, const Vector3<float>& before) const {
    Vector3<float> result = before;
    const bool is_local = item.frame == Frame::kLocal;
    const bool is_placed = has_place(item);
    if (is_placed && is_local) {
        constexpr float kUnit = 1e-4F;
        result.x() = home_N_.x() + kUnit * static_cast<float>(item.x);
        result.y() = home_N_.y() + kUnit * static_cast<float>(item.y);
    } else if (is_placed && knows_earth_) {
        constexpr double kUnit = 1e-7;
        const math::NorthEast at = earth_.to_local({kUnit * item.x, kUnit * item.y});
        result.x() = static_cast<float>(at.north);
        result.y() = static_cast<float>(at.east);
    } else if (is_placed) {
        result.x() = result.y() = kNaN;
    }
    if (item.frame == Frame::kMission || !math::is_finite(item.z)) return result;
    if (is_local) {
        result.z() = home_N_.z() + item.z;
    } else if (item.frame == Frame::kRelative || item.frame == Frame::kRelativeInt) {
        result.z() = home_N_.z() - item.z;
    } else {
        result.z() = knows_sea_ ? reference_altitude_ - item.z : kNaN;
    }
    return result;
}

// A landing descends from where the vehicle is then; the height that it has is that of the ground.
Item item_of(const RawItem& raw, const PlaceFrame& frame, const Vector3<float>& before_N) {
    Item item{.kind = kind_of(raw.command),
              .position_N = frame.place(raw, before_N),
              .param = raw.param,
              .continues = raw.continues};
    if (item.kind == ItemKind::kLand) item.position_N.z() = before_N.z();
    if (item.kind == ItemKind::kTakeoff) item.position_N.head<2>() = before_N.head<2>();
    if (changes_altitude(item.kind)) {
        item.position_N.head<2>() = before_N.head<2>();
    }
    if (item.kind == ItemKind::kReturn || item.kind == ItemKind::kDelay) item.position_N = before_N;
    return item;
}

bool is_flown(uint16_t command) {
    switch (kind_of(command)) {
        case ItemKind::kWaypoint:
        case ItemKind::kLoiterUnlimited:
        case ItemKind::kLoiterTurns:
        case ItemKind::kLoiterTime:
        case ItemKind::kReturn:
        case ItemKind::kLand:
        case ItemKind::kTakeoff:
        case ItemKind::kContinueAndChangeAltitude:
        case ItemKind::kConditionChangeAltitude:
        case ItemKind::kLoiterToAltitude:
        case ItemKind::kEight:
        case ItemKind::kDelay:
            return true;
        default:
            return false;
    }
}

bool is_condition(uint16_t command) {
    const ItemKind kind = kind_of(command);
    return kind == ItemKind::kConditionDelay || kind == ItemKind::kConditionDistance ||
           kind == ItemKind::kConditionYaw;
}

bool is_done_at_once(uint16_t command) {
    switch (kind_of(command)) {
        case ItemKind::kJump:
        case ItemKind::kChangeSpeed:
        case ItemKind::kRegionOfInterestLocation:
        case ItemKind::kRegionOfInterestNone:
        case ItemKind::kRegionOfInterest:
            return true;
        default:
            return false;
    }
}

bool ends_mission(ItemKind kind) {
    return kind == ItemKind::kReturn || kind == ItemKind::kLand ||
           kind == ItemKind::kLoiterUnlimited;
}

bool is_frame_known(Frame frame) {
    switch (frame) {
        case Frame::kGlobal:
        case Frame::kLocal:
        case Frame::kMission:
        case Frame::kRelative:
        case Frame::kGlobalInt:
        case Frame::kRelativeInt:
            return true;
    }
    return false;
}

float hold_of(const Item& item) {
    switch (item.kind) {
        case ItemKind::kLoiterUnlimited:
            return kForever_s;
        case ItemKind::kWaypoint:
        case ItemKind::kLoiterTime:
        case ItemKind::kDelay:
            return positive_or(item.param[0], 0.0F);
        default:
            return 0.0F;
    }
}

float radius_of(const Item& item) {
    return item.kind == ItemKind::kWaypoint ? positive_or(item.param[1], kUsualRadius)
                                            : kUsualRadius;
}

float heading_of(const Item& item) {
    switch (item.kind) {
        case ItemKind::kWaypoint:
        case ItemKind::kLoiterUnlimited:
        case ItemKind::kLand:
            return kDegree * item.param[3];
        default:
            return kNaN;
    }
}

bool is_passed(const Item& item) {
    return item.kind == ItemKind::kWaypoint && item.continues && hold_of(item) == 0.0F;
}

}  // namespace stator::apps::navigator
