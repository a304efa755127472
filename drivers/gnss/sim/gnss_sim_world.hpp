// The simulated satellite receiver as a part of the world.
#pragma once

#include <optional>

#include "gnss_sim_sample.hpp"
#include "world/gnss_part.hpp"
#include "world/world.hpp"

namespace stator::drivers::gnss::sim {

class GnssSimWorld {
  public:
    explicit GnssSimWorld(const world::World& world) : part_(world) {}

    std::optional<GnssSimSample> measure(const world::World& world) {
        const std::optional<world::GnssFix> fix = part_.receive(world);
        if (!fix) return {};
        return GnssSimSample{.timestamp_sample = fix->time_us,
                             .latitude_deg = fix->place.latitude_deg,
                             .longitude_deg = fix->place.longitude_deg,
                             .altitude_msl_m = fix->place.altitude_msl,
                             .altitude_ellipsoid_m = fix->place.altitude_ellipsoid,
                             .velocity_N = math::to_array(fix->velocity_N),
                             .horizontal_error = fix->horizontal_error,
                             .vertical_error = fix->vertical_error,
                             .speed_error = fix->speed_error,
                             .satellites = fix->satellites};
    }

  private:
    world::GnssPart part_;
};

}  // namespace stator::drivers::gnss::sim
