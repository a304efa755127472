// Smooth motion: between the navigator's goals, or the pilot's sticks, and position_control.
#pragma once

#include <cstdint>

#include "motion_plan.hpp"
#include "trajectory_ports.hpp"

namespace stator::apps::trajectory {

// Runs at a fixed period. While disarmed, and in modes that do without it, it follows the estimate
// and leaves every component of the setpoint free. Another goal begins where the setpoint is, so
// that it never jumps. Descending without a position, it sinks level. A vehicle that lags far
// behind is waited for, except in a landing: what cannot be reached is not worth staying up for, so
// the setpoint sinks on and comes along, no further ahead than the limit of lag. On the ground the
// sticks move the setpoint only upwards. In the mode offboard the setpoint is the one that was
// sent, and what follows begins where the vehicle is; without one it stands still.
class Trajectory {
  public:
    void step(TrajectoryPorts& ports);

  private:
    enum class Task { kFollow, kGoal, kSpeeds, kHeightOnly, kSink, kOffboard };

    static Task task_of(const TrajectoryPorts& ports);
    void follow_estimate(const TrajectoryPorts& ports);
    void take_goal(const GotoSetpoint& goal, const TrajectoryParams& params);
    Leg leg_to(const GotoSetpoint& goal, const math::Vector3<float>& rest) const;
    float wait_for(const TrajectoryPorts& ports, float dt);
    void come_along(const VehicleLocalPosition& position, float most);
    void advance_goal(const TrajectoryPorts& ports, float dt);
    void advance_speeds(const TrajectoryPorts& ports, float dt);
    void follow_offboard(const TrajectoryPorts& ports, float dt);
    void turn(float heading, const TrajectoryParams& params, float dt);
    TrajectorySetpoint offboard_setpoint(const TrajectoryPorts& ports) const;
    TrajectorySetpoint setpoint(const TrajectoryPorts& ports) const;

    Task task_ = Task::kFollow;
    PathState state_;
    MotionPlan plan_;
    float plan_time_ = 0.0F;
    float pace_ = 1.0F;  // of plan time against time
    float lags_for_s_ = 0.0F;
    math::Vector3<float> shift_N_ = math::Vector3<float>::Zero();  // of the plan
    bool has_goal_ = false;
    uint32_t goal_number_ = 0;
    float heading_ = 0.0F;  // wanted
    float yaw_rate_ = 0.0F;
    TrajectoryParams limits_{};
    uint64_t last_us_ = 0;
};

}  // namespace stator::apps::trajectory
