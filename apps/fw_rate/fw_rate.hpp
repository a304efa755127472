// Body-rate control of an aeroplane: fw_attitude's rates in, torque for fw_allocation out.
#pragma once

#include <cstdint>

#include "fw_rate_ports.hpp"
#include "stator/rotation.hpp"

namespace stator::apps::fw_rate {

// Per axis, with s = trim airspeed / airspeed, as the torque of a surface grows with its square and
// the damping with the airspeed itself:
//
//     torque = s^2 * (p * error + i * integral of error) + s * ff * setpoint
//
// The airspeed counts from stall up; without one, s = 1.
// An axis whose torque is at its limit integrates only what leads away from there. A setpoint that
// is absent reads as no rotation at the last thrust; a gyro sample that is not a number passes
// unused.
class FwRate {
  public:
    void step(FwRatePorts& ports);

  private:
    void take_setpoint(const FwRatePorts& ports);
    math::Vector3<float> torque(const math::Vector3<float>& rate, const FwRateParams& params,
                                float scale, float dt, bool integrate);

    math::Vector3<float> setpoint_ = math::Vector3<float>::Zero();
    math::Vector3<float> thrust_ = math::Vector3<float>::Zero();
    math::Vector3<float> integral_ = math::Vector3<float>::Zero();
    uint64_t last_sample_us_ = 0;
};

}  // namespace stator::apps::fw_rate
