// Airspeed that control may use, and the wind.
#pragma once

#include <cstdint>

#include "airspeed_check.hpp"
#include "airspeed_selector_ports.hpp"
#include "wind_filter.hpp"

namespace stator::apps::airspeed_selector {

// Runs at a fixed period.
//
//     equivalent = sqrt(2 pressure / rho_0)       true = equivalent sqrt(rho_0 / rho)
//
// In the air the sensor is checked. One that was refused is not used until the next flight; then
// the airspeed is that of ground speed and wind, while the wind is known. A wind that was estimated
// with that sensor is kept, and from then on follows the sideslip alone.
class AirspeedSelector {
  public:
    void step(AirspeedSelectorPorts& ports);

  private:
    void measure(const AirspeedSelectorPorts& ports);
    void fuse(const AirspeedSelectorPorts& ports, float dt);
    void check(const AirspeedSelectorPorts& ports, float dt);

    WindFilter wind_;
    AirspeedCheck check_;
    bool flies_ = false;
    bool was_armed_ = false;
    float pressure_ = math::canonical_nan<float>();
    float equivalent_ = math::canonical_nan<float>();
    float tas_over_eas_ = 1.0F;
    float innovation_ = math::canonical_nan<float>();
    float since_fusion_s_ = 0.0F;
    uint64_t last_us_ = 0;
};

}  // namespace stator::apps::airspeed_selector
