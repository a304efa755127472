// The simulated battery monitor as a part of the world: the battery itself acts there.
#pragma once

#include <optional>

#include "battery_sim_sample.hpp"
#include "world/world.hpp"

namespace stator::drivers::battery::sim {

class BatterySimWorld {
  public:
    explicit BatterySimWorld(const world::World&) {}

    std::optional<BatterySimSample> measure(const world::World& world) {
        constexpr double kMilliampHours = 1.0 / 3.6;  // in a coulomb
        if (!timer_.take(world.time_us())) return {};
        const world::Battery& battery = world.battery();
        return BatterySimSample{
            .voltage_v = static_cast<float>(battery.voltage()),
            .current_a = static_cast<float>(battery.current()),
            .discharged_mah = static_cast<float>(kMilliampHours * battery.discharged_c()),
            .remaining = static_cast<float>(battery.remaining())};
    }

  private:
    world::Timer timer_{.period_us = 50000};
};

}  // namespace stator::drivers::battery::sim
