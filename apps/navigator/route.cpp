// A mission's items as places.
#include "route.hpp"

#include "stator/geodesy.hpp"

namespace stator::apps::navigator {

namespace {

constexpr float kShortestEight = 2.0F;  // m

bool is_last(ItemKind kind) {
    return kind == ItemKind::kReturn || kind == ItemKind::kLand;
}

bool is_number(const Item& item) {
    const bool has_place = math::is_finite(item.position_N.sum()) || item.kind == ItemKind::kReturn;
    const float least = item.kind == ItemKind::kEight ? kShortestEight : 0.0F;
    return has_place && math::is_finite(item.radius + item.hold) && item.radius >= least &&
           item.hold >= 0.0F;
}

bool is_known(ItemKind kind) {
    return kind == ItemKind::kWaypoint || kind == ItemKind::kTakeoff || kind == ItemKind::kEight ||
           is_last(kind);
}

// Of an eight the tips count.
float reach(const Item& item) {
    return item.kind == ItemKind::kEight ? 0.5F * item.radius : 0.0F;
}

// A take-off goes straight up, wherever its place is.
bool is_near(const Item& item, const Eigen::Vector2f& home_N, float farthest) {
    if (item.kind == ItemKind::kTakeoff) return true;
    const float away = math::norm(Eigen::Vector2f(item.position_N.head<2>() - home_N));
    return away + reach(item) <= farthest;
}

// `item` as seen from home.
bool has_good_height(const Item& item, float fence_height) {
    const float height = -item.position_N.z();
    if (fence_height > 0.0F && height > fence_height) return false;
    return item.kind == ItemKind::kLand || height > 0.0F;
}

}  // namespace

Eigen::Vector2f origin_N(const Mission& mission, const VehicleLocalPosition& position,
                         const Eigen::Vector2f& home_N) {
    if (!math::is_finite(mission.origin_lat)) return home_N;
    if (!position.xy_global) return Eigen::Vector2f::Constant(math::canonical_nan<float>());
    const math::LocalFrame N({position.ref_lat, position.ref_lon});
    const math::NorthEast origin = N.to_local({mission.origin_lat, mission.origin_lon});
    return {static_cast<float>(origin.north), static_cast<float>(origin.east)};
}

Item item_at(const Mission& mission, unsigned index, const Eigen::Vector2f& origin_N,
             float home_z) {
    return {.kind = static_cast<ItemKind>(mission.kind[index]),
            .position_N = {origin_N.x() + mission.north[index], origin_N.y() + mission.east[index],
                           home_z - mission.height[index]},
            .heading = mission.heading[index],
            .radius = mission.radius[index],
            .hold = mission.hold[index],
            .speed = mission.speed[index]};
}

bool is_flyable(const Mission& mission, const Eigen::Vector2f& origin_N,
                const Eigen::Vector2f& home_N, float farthest) {
    if (mission.count == 0 || mission.count > mission.kind.size()) return false;
    const float fence = mission.fence_radius > 0.0F ? mission.fence_radius : farthest;
    const float most = math::min(farthest, fence);
    for (unsigned i = 0; i < mission.count; ++i) {
        const Item item = item_at(mission, i, origin_N, 0.0F);
        const bool is_first = i == 0;
        const bool ends = i + 1U == mission.count;
        if (!is_known(item.kind) || !is_number(item)) return false;
        if ((item.kind == ItemKind::kTakeoff) != is_first) return false;
        if (is_last(item.kind) && !ends) return false;
        if (item.kind == ItemKind::kReturn) continue;
        if (!is_near(item, home_N, most) || !has_good_height(item, mission.fence_height))
            return false;
    }
    return true;
}

}  // namespace stator::apps::navigator
