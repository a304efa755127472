// The simulated barometer as a part of the world.
#pragma once

#include <optional>

#include "baro_sim_sample.hpp"
#include "world/navigation_sensors.hpp"
#include "world/world.hpp"

namespace stator::drivers::baro::sim {

class BaroSimWorld {
  public:
    explicit BaroSimWorld(const world::World& world)
        : barometer_(world.vehicle().barometer, world.conditions().earth, world.conditions().seed),
          timer_{world.vehicle().barometer.period_us} {}

    std::optional<BaroSimSample> measure(const world::World& world) {
        if (!timer_.take(world.time_us())) return {};
        if (world.has_fault(world::FaultKind::kBaroLoss)) return {};
        const world::BarometerSample sample = barometer_.measure(world.plant());
        return BaroSimSample{.timestamp_sample = world.time_us(),
                             .pressure = sample.pressure,
                             .temperature_degc = sample.temperature_degc};
    }

  private:
    world::Barometer barometer_;
    world::Timer timer_;
};

}  // namespace stator::drivers::baro::sim
