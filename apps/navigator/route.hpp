// A mission's items as places of N, and whether they can be flown.
#pragma once

#include "messages/mission.hpp"
#include "messages/vehicle_local_position.hpp"
#include "stator/rotation.hpp"

namespace stator::apps::navigator {

// As commands of MAVLink, common.xml.
enum class ItemKind : uint8_t {
    kWaypoint = 16,
    kReturn = 20,
    kLand = 21,
    kTakeoff = 22,
    kEight = 35,
};

struct Item {
    ItemKind kind;
    math::Vector3<float> position_N;
    float heading;  // not a number: towards it
    float radius;   // of an eight: its length
    float hold;     // s; of an eight: its laps
    float speed;    // not a number: as fast as usual
};

// North and east of the mission's origin in N; home, if it has none of its own. Not a number while
// it is not known.
Eigen::Vector2f origin_N(const Mission& mission, const VehicleLocalPosition& position,
                         const Eigen::Vector2f& home_N);

// `index` below the mission's count.
Item item_at(const Mission& mission, unsigned index, const Eigen::Vector2f& origin_N, float home_z);

// It begins with a take-off, ends with what ends it, is all numbers, and stays above home and near:
// within `farthest` and the mission's own fence.
bool is_flyable(const Mission& mission, const Eigen::Vector2f& origin_N,
                const Eigen::Vector2f& home_N, float farthest);

}  // namespace stator::apps::navigator
