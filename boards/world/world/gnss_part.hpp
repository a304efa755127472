// A satellite receiver as a part of the world: each fix arrives some time after its instant.
#pragma once

#include <optional>

#include "world/navigation_sensors.hpp"
#include "world/world.hpp"

namespace stator::world {

class GnssPart {
  public:
    explicit GnssPart(const World& world);
    // At each event of the world: the fix that arrives now.
    std::optional<GnssFix> receive(const World& world);

  private:
    GnssParameters parameters_{};
    GnssReceiver receiver_;
    Timer timer_{parameters_.period_us};
    std::optional<GnssReceiver::Sending> sending_;  // on its way
};

}  // namespace stator::world
