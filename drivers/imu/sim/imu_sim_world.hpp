// The simulated IMU as a part of the world: it samples all the time.
#pragma once

#include <optional>

#include "imu_sim_sample.hpp"
#include "world/sensors.hpp"
#include "world/world.hpp"

namespace stator::drivers::imu::sim {

class ImuSimWorld {
  public:
    explicit ImuSimWorld(const world::World& world)
        : imu_(world.vehicle().imu, world.vehicle().airframe.rotor_count(),
               world.conditions().seed),
          timer_{world.vehicle().imu.period_us} {}

    std::optional<ImuSimSample> measure(const world::World& world) {
        if (!timer_.take(world.time_us())) return {};
        const world::ImuSample sample = imu_.measure(world.plant());
        return ImuSimSample{.timestamp_sample = world.time_us(),
                            .gyro_B = math::to_array(sample.gyro_B),
                            .accel_B = math::to_array(sample.accel_B)};
    }

  private:
    world::Imu imu_;
    world::Timer timer_;
};

}  // namespace stator::drivers::imu::sim
