// The simulated magnetometer as a part of the world.
#pragma once

#include <optional>

#include "mag_sim_sample.hpp"
#include "world/navigation_sensors.hpp"
#include "world/world.hpp"

namespace stator::drivers::mag::sim {

class MagSimWorld {
  public:
    explicit MagSimWorld(const world::World& world)
        : magnetometer_(world.vehicle().magnetometer, world.conditions().earth,
                        world.conditions().seed),
          timer_{world.vehicle().magnetometer.period_us} {}

    std::optional<MagSimSample> measure(const world::World& world) {
        if (!timer_.take(world.time_us())) return {};
        const world::Plant& plant = world.plant();
        const auto field_B = magnetometer_.measure(plant.state(), plant.influence().current);
        return MagSimSample{.timestamp_sample = world.time_us(),
                            .field_B_gauss = math::to_array(field_B)};
    }

  private:
    world::Magnetometer magnetometer_;
    world::Timer timer_;
};

}  // namespace stator::drivers::mag::sim
