// The simulated pitot tube as a part of the world.
#pragma once

#include <optional>

#include "airspeed_sim_sample.hpp"
#include "world/pitot.hpp"
#include "world/world.hpp"

namespace stator::drivers::airspeed::sim {

class AirspeedSimWorld {
  public:
    explicit AirspeedSimWorld(const world::World& world)
        : pitot_(world::PitotParameters{}, world.conditions().earth, world.conditions().seed),
          timer_{world::PitotParameters{}.period_us} {}

    std::optional<AirspeedSimSample> measure(const world::World& world) {
        if (!timer_.take(world.time_us())) return {};
        const world::PitotSample sample = pitot_.measure(world.plant(), world.conditions().faults);
        return AirspeedSimSample{.timestamp_sample = world.time_us(),
                                 .pressure = sample.pressure,
                                 .temperature_degc = sample.temperature_degc};
    }

  private:
    world::Pitot pitot_;
    world::Timer timer_;
};

}  // namespace stator::drivers::airspeed::sim
