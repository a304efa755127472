// The simulated radio receiver as a part of the world: the pilot has the transmitter.
#pragma once

#include <optional>

#include "radio_sim_sample.hpp"
#include "world/world.hpp"

namespace stator::drivers::radio::sim {

class RadioSimWorld {
  public:
    // Programmed into the receiver for the case that it hears nothing, as many do: the sticks in
    // their middle, the throttle down.
    static constexpr float kThrottleDown = -1.0F;

    explicit RadioSimWorld(const world::World&) {}

    std::optional<RadioSimSample> measure(const world::World& world) {
        if (!timer_.take(world.time_us())) return {};
        using Kind = world::FaultKind;
        const auto has = [&](Kind kind) { return world.has_fault(kind); };
        const world::PilotFrame before = hands_;
        const bool is_heard = !has(Kind::kRcLoss);
        if (is_heard) hands_ = world.conditions().pilot.frame(world.time_us());
        if (has(Kind::kSilence)) return {};
        if (has(Kind::kStuckStick)) {
            hands_.roll = before.roll;
            hands_.pitch = before.pitch;
            hands_.yaw = before.yaw;
            hands_.throttle = before.throttle;
        }
        if (has(Kind::kPreset)) {
            hands_ = {.throttle = kThrottleDown, .mode_slot = hands_.mode_slot, .arm = hands_.arm};
        }
        return RadioSimSample{.timestamp_sample = world.time_us(),
                              .roll = hands_.roll,
                              .pitch = hands_.pitch,
                              .yaw = hands_.yaw,
                              .throttle = hands_.throttle,
                              .mode_slot = hands_.mode_slot,
                              .is_heard = is_heard,
                              .arm = hands_.arm,
                              .return_home = hands_.return_home,
                              .kill = hands_.kill};
    }

  private:
    world::PilotFrame hands_{};  // the newest ones heard
    world::Timer timer_{.period_us = world::Pilot::kPeriod_us};
};

}  // namespace stator::drivers::radio::sim
