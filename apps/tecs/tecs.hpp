// Height, airspeed and bank of an aeroplane: fw_guidance's setpoints in, attitude for fw_attitude
// out.
#pragma once

#include <cstdint>

#include "energy_control.hpp"
#include "stator/rotation.hpp"
#include "tecs_ports.hpp"

namespace stator::apps::tecs {

// Runs with estimates of the position. The bank is that of a level turn with the wanted lateral
// acceleration; it is limited to what the airspeed can carry above stall. Setpoints that are absent
// read as straight and level. Disarmed it wants no throttle.
class Tecs {
  public:
    void step(TecsPorts& ports);

  private:
    Motion motion_of(const TecsPorts& ports) const;
    float roll_for(const TecsPorts& ports, const Motion& motion, float dt);

    EnergyControl energy_;
    float roll_ = 0.0F;
    uint64_t last_us_ = 0;
};

}  // namespace stator::apps::tecs
