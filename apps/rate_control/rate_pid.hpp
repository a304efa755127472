// PID control of the three body rates, with the derivative of the low-passed measurement.
#pragma once

#include "stator/rotation.hpp"

namespace stator::apps::rate_control {

// Per axis x, y, z of B. Torque is a share of the most that the motors make about the axis.
struct RateGains {
    math::Vector3<float> p;
    math::Vector3<float> i;
    math::Vector3<float> d;
    float integral_limit;     // torque
    float derivative_cutoff;  // rad/s
};

//     torque = p * error + i * integral of error - d * derivative of the low-passed rate
//
// The measured rate, not the error, is differentiated, so that a step of the setpoint does not
// kick. An axis whose torque is at its limit integrates only what leads away from there.
class RatePid {
  public:
    void set_gains(const RateGains& gains) { gains_ = gains; }
    void reset_integral() { integral_.setZero(); }

    // Rates in rad/s, dt > 0 in s. With `integrate` false the integral keeps its value.
    math::Vector3<float> update(const math::Vector3<float>& rate,
                                const math::Vector3<float>& setpoint, float dt, bool integrate);

  private:
    math::Vector3<float> filtered_derivative(const math::Vector3<float>& rate, float dt);

    RateGains gains_{};
    math::Vector3<float> integral_ = math::Vector3<float>::Zero();
    // The low pass's two integrators: of the low-pass and of the band-pass output.
    math::Vector3<float> low_ = math::Vector3<float>::Zero();
    math::Vector3<float> band_ = math::Vector3<float>::Zero();
    bool started_ = false;
};

}  // namespace stator::apps::rate_control
