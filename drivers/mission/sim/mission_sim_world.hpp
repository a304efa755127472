// The memory of the mission as a part of the world, in which it can be lost.
#pragma once

#include <optional>

#include "mission_sim_sample.hpp"
#include "world/world.hpp"

namespace stator::drivers::mission::sim {

class MissionSimWorld {
  public:
    explicit MissionSimWorld(const world::World&) {}

    std::optional<MissionSimSample> measure(const world::World& world) {
        const bool is_lost = world.has_fault(world::FaultKind::kMissionLoss);
        if (is_lost == was_lost_) return {};
        was_lost_ = is_lost;
        return MissionSimSample{is_lost};
    }

  private:
    bool was_lost_ = false;
};

}  // namespace stator::drivers::mission::sim
