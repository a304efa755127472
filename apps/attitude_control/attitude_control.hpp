// Attitude control: position_control's attitude in, body rates for rate_control out.
#pragma once

#include "attitude_control_ports.hpp"
#include "stator/rotation.hpp"

namespace stator::apps::attitude_control {

// A proportional law on the error quaternion that corrects tilt before heading, as thrust follows
// tilt alone: Brescianini, Hehn, D'Andrea: Nonlinear Quadrocopter Attitude Control, ETH Zurich,
// Technical Report, 2013.
//
//     q_NB^-1 * q_NB_setpoint = q_tilt * q_yaw     q_tilt the shortest turn of the thrust axis
//     rates = 2 * (tilt_p * q_tilt.x, tilt_p * q_tilt.y, yaw_p * q_yaw.z)
//
// In the modes manual and stabilized the sticks are the setpoint; armed, one that is absent while
// they are not heard.
//
// In the mode offboard the setpoint is the one that was sent, if it is an attitude or rates.
//
// Before the first setpoint it wants no rotation and no thrust; a setpoint that is absent later, or
// not a number, reads as level at the present heading and the last thrust.
class AttitudeControl {
  public:
    void step(AttitudeControlPorts& ports);

  private:
    math::Vector3<float> rates_setpoint(const AttitudeControlPorts& ports);

    std::array<float, 3> thrust_body_{};
    bool has_setpoint_ = false;
};

}  // namespace stator::apps::attitude_control
