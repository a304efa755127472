// Attitude control of an aeroplane: tecs' attitude in, body rates for fw_rate out.
#pragma once

#include "fw_attitude_ports.hpp"
#include "stator/rotation.hpp"

namespace stator::apps::fw_attitude {

// Roll and pitch go to their setpoints like first-order lags. A banked aeroplane that does not
// slip turns, and its body rates follow from the turn:
//
//     yaw' = g tan(roll) cos(pitch) / V
//     p = roll' - sin(pitch) yaw'
//     q = cos(roll) pitch' + sin(roll) cos(pitch) yaw'
//     r = cos(roll) cos(pitch) yaw' - sin(roll) pitch'
//
// In the modes manual and stabilized the sticks are the setpoint. A setpoint that is absent or not
// a number reads as level wings at level_pitch with the last thrust; before the first one it wants
// no rotation and no thrust.
class FwAttitude {
  public:
    void step(FwAttitudePorts& ports);

  private:
    math::Vector3<float> rates(const FwAttitudePorts& ports);

    std::array<float, 3> thrust_body_{};
    bool has_setpoint_ = false;
};

}  // namespace stator::apps::fw_attitude
