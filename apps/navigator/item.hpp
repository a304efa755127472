// One item of a mission: what of it is flown, and where. Commands and frames are MAVLink's
// (common.xml). The ground reads the numbers here: codegen/stator/mission/commands.py.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

#include "messages/mission_items.hpp"
#include "messages/vehicle_local_position.hpp"
#include "stator/geodesy.hpp"
#include "stator/rotation.hpp"

namespace stator::apps::navigator {

// What is flown, or done at once.
enum class ItemKind : uint16_t {
    kWaypoint = 16,
    kLoiterUnlimited = 17,
    kLoiterTurns = 18,
    kLoiterTime = 19,
    kReturn = 20,
    kLand = 21,
    kTakeoff = 22,
    kContinueAndChangeAltitude = 30,
    kLoiterToAltitude = 31,
    kEight = 35,
    kRegionOfInterestNav = 80,
    kSplineWaypoint = 82,
    kVtolTakeoff = 84,
    kVtolLand = 85,
    kDelay = 93,
    kConditionDelay = 112,
    kConditionChangeAltitude = 113,
    kConditionDistance = 114,
    kConditionYaw = 115,
    kJump = 177,
    kChangeSpeed = 178,
    kRegionOfInterestLocation = 195,
    kRegionOfInterestNone = 197,
    kRegionOfInterest = 201,
};

// What stays in a mission and is passed by: marks, and work for devices that this vehicle lacks
// (cameras, gimbals, servos, a wing).
inline constexpr std::array<uint16_t, 34> kPassedBy{
    181,  182,  183,  184,  189,  196,  202,  203,  204,  205,  206,  211,
    214,  220,  530,  531,  532,  534,  600,  1000, 1001, 2000, 2001, 2003,
    2004, 2005, 2010, 2500, 2501, 2502, 2503, 2800, 3000, 42600};

enum class Frame : uint8_t {
    kGlobal = 0,       // height above mean sea level
    kLocal = 1,        // north, east, down from home
    kMission = 2,      // no place
    kRelative = 3,     // height above home
    kGlobalInt = 5,    // as kGlobal
    kRelativeInt = 6,  // as kRelative
};

inline constexpr float kUsualRadius = 1.0F;    // m, at which a waypoint counts as reached
inline constexpr float kShortestEight = 2.0F;  // m
inline constexpr int32_t kNoPlace = INT32_MAX;

// As the mission device has it.
struct RawItem {
    uint16_t command;
    Frame frame;
    bool continues;  // 0 of autocontinue: the mission waits behind it
    std::array<float, 4> param;
    int32_t x;
    int32_t y;
    float z;
};

// A latitude and longitude of 0 stand for none, as ground stations write them.
inline bool has_place(const RawItem& item) {
    const bool is_given = item.x != kNoPlace && item.y != kNoPlace && item.frame != Frame::kMission;
    return is_given && (item.frame == Frame::kLocal || item.x != 0 || item.y != 0);
}

inline RawItem raw_item(const MissionItems& items, unsigned at) {
    return {.command = items.command[at],
            .frame = static_cast<Frame>(items.frame[at]),
            .continues = items.autocontinue[at] != 0,
            .param = {items.param1[at], items.param2[at], items.param3[at], items.param4[at]},
            .x = items.x[at],
            .y = items.y[at],
            .z = items.z[at]};
}

// Where places of items lie in N.
class PlaceFrame {
  public:
    // Moves on to a newer position; what an origin costs is paid only for another origin.
    void update(const VehicleLocalPosition& position, const math::Vector3<float>& home_N) {
        const bool is_other = position.ref_lat != earth_.origin().latitude_deg ||
                              position.ref_lon != earth_.origin().longitude_deg;
        if (is_other) earth_ = math::LocalFrame({position.ref_lat, position.ref_lon});
        home_N_ = home_N;
        reference_altitude_ = position.ref_alt;
        knows_earth_ = position.xy_global;
        knows_sea_ = position.z_global;
    }

    const math::Vector3<float>& home_N() const { return home_N_; }
    bool knows_earth() const { return knows_earth_; }
    bool knows_sea() const { return knows_sea_; }
    // In N; not a number while it is not known. An item without a place has that of `before`.
    math::Vector3<float> place(const RawItem& item, const math::Vector3<float>& before) const;

  private:
    math::Vector3<float> home_N_ = math::Vector3<float>::Zero();
    math::LocalFrame earth_;
    float reference_altitude_ = 0.0F;
    bool knows_earth_ = false;
    bool knows_sea_ = false;
};

// An item that is flown or done.
struct Item {
    ItemKind kind;
    math::Vector3<float> position_N;
    std::array<float, 4> param;
    bool continues;
};

Item item_of(const RawItem& raw, const PlaceFrame& frame, const math::Vector3<float>& before_N);

inline bool is_passed_by(uint16_t command) {
    return std::find(kPassedBy.begin(), kPassedBy.end(), command) != kPassedBy.end();
}
bool is_flown(uint16_t command);      // the vehicle goes somewhere, or stays for a time
bool is_condition(uint16_t command);  // what follows it waits, on the way to the next place
bool is_done_at_once(uint16_t command);
bool ends_mission(ItemKind kind);
bool is_frame_known(Frame frame);
// How long it stays there, s.
float hold_of(const Item& item);
// How near is there, m.
float radius_of(const Item& item);
// The heading there; not a number: towards it.
float heading_of(const Item& item);
// A waypoint that is flown past without a stop.
bool is_passed(const Item& item);

}  // namespace stator::apps::navigator
