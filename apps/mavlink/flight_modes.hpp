// Flight modes as PX4 tells them in MAVLink's custom_mode: main mode in byte 2, sub-mode in byte 3;
// and as MAVLink's standard modes.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

#include "messages/vehicle_status.hpp"

namespace stator::apps::mavlink {

struct FlightMode {
    VehicleStatus::NavState nav_state;
    uint8_t main;
    uint8_t sub;
    bool is_manual;  // flown by sticks
    bool may_be_chosen;
    uint8_t standard;  // of MAV_STANDARD_MODE; 0: none
    const char* name;  // for people, of a mode without a standard
};

// The first row of a mode of ours is how it is told. What cannot be chosen is only told.
inline constexpr std::array kFlightModes{
    FlightMode{VehicleStatus::NavState::kManual, 1, 0, true, true, 0, "Manual"},
    FlightMode{VehicleStatus::NavState::kAltitude, 2, 0, true, true, 4, ""},
    FlightMode{VehicleStatus::NavState::kPosition, 3, 0, true, true, 1, ""},
    FlightMode{VehicleStatus::NavState::kTakeoff, 4, 2, false, true, 8, ""},
    FlightMode{VehicleStatus::NavState::kHold, 4, 3, false, true, 0, "Hold"},
    FlightMode{VehicleStatus::NavState::kMission, 4, 4, false, true, 6, ""},
    FlightMode{VehicleStatus::NavState::kReturn, 4, 5, false, true, 5, ""},
    FlightMode{VehicleStatus::NavState::kLand, 4, 6, false, true, 7, ""},
    FlightMode{VehicleStatus::NavState::kDescend, 4, 6, false, false, 7, ""},
    FlightMode{VehicleStatus::NavState::kTermination, 1, 0, false, false, 0, ""},
    FlightMode{VehicleStatus::NavState::kOffboard, 6, 0, false, true, 0, "Offboard"},
    FlightMode{VehicleStatus::NavState::kStabilized, 7, 0, true, true, 0, "Stabilized"},
};

constexpr uint32_t custom_mode(const FlightMode& mode) {
    return uint32_t{mode.main} << 16 | uint32_t{mode.sub} << 24;
}

constexpr const FlightMode& mode_of(VehicleStatus::NavState nav_state) {
    for (const FlightMode& mode : kFlightModes) {
        if (mode.nav_state == nav_state) return mode;
    }
    return kFlightModes[4];
}

inline constexpr auto kModesToChoose =
    static_cast<uint8_t>(std::ranges::count(kFlightModes, true, &FlightMode::may_be_chosen));

// The mode of this number among those that can be chosen, from 0 on and below kModesToChoose.
constexpr const FlightMode& mode_to_choose(unsigned number) {
    for (const FlightMode& mode : kFlightModes) {
        if (mode.may_be_chosen && number-- == 0) return mode;
    }
    return kFlightModes[4];
}

// Null if the mode cannot be chosen.
constexpr const FlightMode* find_mode(uint32_t main, uint32_t sub) {
    for (const FlightMode& mode : kFlightModes) {
        const bool is_it = mode.main == main && (mode.main != 4 || mode.sub == sub);
        if (mode.may_be_chosen && is_it) return &mode;
    }
    return nullptr;
}

}  // namespace stator::apps::mavlink
