// Position and velocity control of a point mass: from a wanted motion to a thrust vector.
#pragma once

#include "messages/trajectory_setpoint.hpp"
#include "stator/rotation.hpp"

namespace stator::apps::position_control {

// Per axis of N: north, east, down.
struct MotionGains {
    math::Vector3<float> position_p;
    math::Vector3<float> velocity_p;
    math::Vector3<float> velocity_i;
    math::Vector3<float> velocity_d;
    float derivative_cutoff;  // rad/s
    float integral_limit;     // m/s^2
};

struct MotionLimits {
    float horizontal_speed;
    float climb;
    float descent;
    float tan_tilt;
    float lean_margin;   // of the most thrust, kept for horizontal control
    float thrust_min;    // share of the most, as all thrust here
    float hover_thrust;  // carries the weight
    float blind_sink;    // m/s^2
    float drag;          // 1/s
};

// What is not known is not a number.
struct MotionEstimate {
    math::Vector3<float> position_N;
    math::Vector3<float> velocity_N;
    float climb;  // m/s, as the height alone shows it
};

//     velocity_setpoint = position_p * position error + velocity feed-forward
//     acceleration = p * velocity error + i * its integral - d * low-passed acceleration
//                    + acceleration feed-forward + drag * velocity feed-forward
//     thrust_N = hover_thrust / g * (acceleration - (0, 0, g))
//
// Weight goes before direction: the thrust vector is cut first in height, down to a margin for
// horizontal control, then in tilt. An axis
// that was cut integrates only what leads away from its limit. An axis whose setpoint is free, or
// whose velocity is unknown, keeps its integral and feed-forward alone; the vertical one then
// sinks, with less thrust the longer and the faster the height rises.
class Motion {
  public:
    void set_gains(const MotionGains& gains) { gains_ = gains; }
    void set_limits(const MotionLimits& limits) { limits_ = limits; }
    void reset();
    // Another hover thrust, while thrust stays the same: the integral makes up for it.
    void set_hover_thrust(float hover_thrust);

    // dt > 0 in s; `thrust_max` is the longest thrust vector. Thrust in N, upwards negative.
    math::Vector3<float> update(const MotionEstimate& estimate, const TrajectorySetpoint& setpoint,
                                float dt, float thrust_max);

  private:
    math::Vector3<float> velocity_error(const MotionEstimate& estimate,
                                        const TrajectorySetpoint& setpoint) const;
    math::Vector3<float> limited_velocity(math::Vector3<float> velocity) const;
    math::Vector3<float> limited_thrust(math::Vector3<float> thrust_N, float thrust_max) const;
    float blind_sink(float climb, float dt);
    math::Vector3<float> measured_acceleration(const math::Vector3<float>& velocity_N, float dt);

    MotionGains gains_{};
    MotionLimits limits_{};
    math::Vector3<float> integral_ = math::Vector3<float>::Zero();
    math::Vector3<float> low_passed_velocity_ =
        math::Vector3<float>::Constant(math::canonical_nan<float>());
};

}  // namespace stator::apps::position_control
