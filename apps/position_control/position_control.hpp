// Position and velocity control: a trajectory in, an attitude and thrust for attitude_control out.
#pragma once

#include <cstdint>

#include "hover_thrust.hpp"
#include "motion.hpp"
#include "position_control_ports.hpp"

namespace stator::apps::position_control {

// Runs with every position estimate. Disarmed, without a status, and on the ground until it is
// to climb, it wants level and no thrust, or very little. While the pilot's sticks are the attitude
// (modes manual and stabilized), or the mode offboard has an attitude of its own, it wants nothing:
// its setpoint is not a number. Without a setpoint it stands still. Without a position, if
// something else activates it, it waits a moment, then sinks level; so it does axis by axis with
// what the estimate calls invalid.
class PositionControl {
  public:
    void step(PositionControlPorts& ports);

  private:
    void configure(const PositionControlParams& params);
    bool take_position(const PositionControlPorts& ports);
    float climb_of(const VehicleLocalPosition& position);
    float thrust_max(const PositionControlParams& params, float dt);

    void learn_hover_thrust(const PositionControlPorts& ports, float dt);

    Motion motion_;
    HoverThrust hover_;
    math::Vector3<float> thrust_N_ = math::Vector3<float>::Zero();
    MotionEstimate estimate_{};
    float height_ = math::canonical_nan<float>();  // when it was known last
    float climb_ = 0.0F;
    uint8_t z_resets_ = 0;
    uint64_t climb_us_ = 0;
    float heading_ = 0.0F;
    float armed_for_s_ = 0.0F;
    uint64_t last_us_ = 0;           // time that the latest step was for
    uint64_t last_position_us_ = 0;  // `now` of the latest position
};

}  // namespace stator::apps::position_control
