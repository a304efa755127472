// The simulated range finder as a part of the world: 20 Hz, 2 cm of noise.
#pragma once

#include <optional>

#include "range_sim_sample.hpp"
#include "world/world.hpp"

namespace stator::drivers::range::sim {

class RangeSimWorld {
  public:
    explicit RangeSimWorld(const world::World& world)
        : random_(world.conditions().seed, world::stream_of("range")) {}

    std::optional<RangeSimSample> measure(const world::World& world) {
        if (!timer_.take(world.time_us())) return {};
        const auto height = static_cast<float>(-world.plant().state().position_N.z());
        return RangeSimSample{.timestamp_sample = world.time_us(),
                              .distance = height + 0.02F * random_.gaussian_float()};
    }

  private:
    math::Random random_;
    world::Timer timer_{.period_us = 50000};
};

}  // namespace stator::drivers::range::sim
