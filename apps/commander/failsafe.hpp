// What the failsafe table says about a mode while events last.
#pragma once

#include <cstdint>

#include "failsafe_table.hpp"

namespace stator::apps::commander {

// A bit per event, as in FailsafeEvent.
using Events = uint32_t;

constexpr Events bit(FailsafeEvent event) {
    return Events{1} << static_cast<unsigned>(event);
}

struct Fallback {
    VehicleStatus::NavState mode;
    VehicleStatus::FailsafeEvent reason;  // none: the mode goes on
};

// One step down: by the most urgent of the events that does not go on. `params` choose columns.
template <class Params>
constexpr Fallback fall_back(VehicleStatus::NavState mode, Events events, const Params& params) {
    for (unsigned event = 0; event < kFailsafeEvents; ++event) {
        if ((events >> event & 1U) == 0) continue;
        const VehicleStatus::NavState next = after(mode, static_cast<FailsafeEvent>(event), params);
        if (next != mode) return {next, static_cast<VehicleStatus::FailsafeEvent>(event + 1)};
    }
    return {mode, VehicleStatus::FailsafeEvent::kNone};
}

// On the ground: the most urgent of the events that disarm.
constexpr VehicleStatus::FailsafeEvent disarming(VehicleStatus::NavState mode, Events events) {
    for (unsigned event = 0; event < kFailsafeEvents; ++event) {
        if ((events >> event & 1U) == 0) continue;
        if (disarms(mode, static_cast<FailsafeEvent>(event)))
            return static_cast<VehicleStatus::FailsafeEvent>(event + 1);
    }
    return VehicleStatus::FailsafeEvent::kNone;
}

template <class Params>
constexpr bool goes_on(VehicleStatus::NavState mode, Events events, const Params& params) {
    return fall_back(mode, events, params).reason == VehicleStatus::FailsafeEvent::kNone;
}

}  // namespace stator::apps::commander
