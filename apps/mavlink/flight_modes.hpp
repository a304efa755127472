// Flight modes as PX4 tells them in MAVLink's custom_mode: main mode in byte 2, sub-mode in byte 3.
#pragma once

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
};

// The first row of a mode of ours is how it is told. What cannot be chosen is only told.
inline constexpr std::array kFlightModes{
    FlightMode{VehicleStatus::NavState::kManual, 1, 0, true, true},
    FlightMode{VehicleStatus::NavState::kAltitude, 2, 0, true, true},
    FlightMode{VehicleStatus::NavState::kPosition, 3, 0, true, true},
    FlightMode{VehicleStatus::NavState::kTakeoff, 4, 2, false, true},
    FlightMode{VehicleStatus::NavState::kHold, 4, 3, false, true},
    FlightMode{VehicleStatus::NavState::kMission, 4, 4, false, true},
    FlightMode{VehicleStatus::NavState::kReturn, 4, 5, false, true},
    FlightMode{VehicleStatus::NavState::kLand, 4, 6, false, true},
    FlightMode{VehicleStatus::NavState::kDescend, 4, 6, false, false},
    FlightMode{VehicleStatus::NavState::kTermination, 1, 0, false, false},
    FlightMode{VehicleStatus::NavState::kOffboard, 6, 0, false, true},
    FlightMode{VehicleStatus::NavState::kStabilized, 7, 0, true, true},
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

// Null if the mode cannot be chosen.
constexpr const FlightMode* find_mode(uint32_t main, uint32_t sub) {
    for (const FlightMode& mode : kFlightModes) {
        const bool is_it = mode.main == main && (mode.main != 4 || mode.sub == sub);
        if (mode.may_be_chosen && is_it) return &mode;
    }
    return nullptr;
}

}  // namespace stator::apps::mavlink
