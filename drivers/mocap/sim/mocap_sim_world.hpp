// The simulated motion capture as a part of the world: pictures arrive some time later.
#pragma once

#include <optional>

#include "mocap_sim_sample.hpp"
#include "world/sensors.hpp"
#include "world/world.hpp"

namespace stator::drivers::mocap::sim {

class MocapSimWorld {
  public:
    explicit MocapSimWorld(const world::World& world)
        : mocap_(parameters_, world.conditions().seed) {}

    std::optional<MocapSimSample> measure(const world::World& world) {
        std::optional<MocapSimSample> arrived;
        if (arrival_timer_.take(world.time_us())) {
            arrived = {.timestamp_sample = picture_.time_us,
                       .position_N = math::to_array(picture_.position_N),
                       .yaw = picture_.yaw};
        }
        if (picture_timer_.take(world.time_us())) picture_ = mocap_.measure(world.plant());
        return arrived;
    }

  private:
    world::MocapParameters parameters_{};
    world::Mocap mocap_;
    world::Timer picture_timer_{parameters_.period_us};
    world::Timer arrival_timer_{parameters_.period_us, parameters_.delay_us};
    world::MocapSample picture_{};  // on its way
};

}  // namespace stator::drivers::mocap::sim
