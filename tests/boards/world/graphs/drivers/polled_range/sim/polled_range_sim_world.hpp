// The simulated range finder as a part of the world: exact, each millisecond.
#pragma once

#include <optional>

#include "polled_range_sim_sample.hpp"
#include "world/world.hpp"

namespace stator::drivers::polled_range::sim {

class PolledRangeSimWorld {
  public:
    explicit PolledRangeSimWorld(const world::World&) {}

    std::optional<PolledRangeSimSample> measure(const world::World& world) {
        return PolledRangeSimSample{static_cast<float>(-world.plant().state().position_N.z())};
    }
};

}  // namespace stator::drivers::polled_range::sim
