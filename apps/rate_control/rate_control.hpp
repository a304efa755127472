// Body-rate control, the innermost loop: attitude_control's rates in, torque for allocation out.
#pragma once

#include <cstdint>

#include "rate_control_ports.hpp"
#include "rate_pid.hpp"

namespace stator::apps::rate_control {

// Runs with every gyro sample. Before the first setpoint it wants neither torque nor thrust; a
// setpoint that is absent later reads as no rotation at the last thrust. A gyro sample that is not
// a number passes unused, so the motors keep their command.
class RateControl {
  public:
    void step(RateControlPorts& ports);

  private:
    void take_setpoint(const VehicleRatesSetpoint& setpoint);
    bool may_integrate(const RateControlPorts& ports);

    RatePid pid_;
    math::Vector3<float> setpoint_ = math::Vector3<float>::Zero();
    math::Vector3<float> thrust_ = math::Vector3<float>::Zero();
    float integrate_from_ = 0.0F;
    uint64_t last_sample_us_ = 0;
};

}  // namespace stator::apps::rate_control
