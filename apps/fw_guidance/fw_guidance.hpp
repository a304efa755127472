// Leads an aeroplane: the navigator's goals in, wanted turn, height and airspeed for tecs out.
#pragma once

#include <cstdint>

#include "fw_guidance_ports.hpp"
#include "landing.hpp"

namespace stator::apps::fw_guidance {

// Runs with estimates of the position. A goal that is a place is flown to in a straight line from
// the one before, and then round in a circle, as an aeroplane cannot stop; it is reached where the
// turn to the next one begins. Standing on the ground, a goal above starts a take-off, which leads
// straight on; nothing else does. A landing follows landing.hpp. Descending without a position it
// circles down with a gentle bank and without throttle. One that sinks further and further below
// its height cannot follow: its motor is out. Disarmed it wants nothing.
class FwGuidance {
  public:
    void step(FwGuidancePorts& ports);

  private:
    enum class Stage { kGround, kRoll, kClimbOut, kFlight, kLanded };

    void take_inputs(const FwGuidancePorts& ports);
    void take_goal(const FwGuidancePorts& ports);
    void begin_landing(const FwGuidancePorts& ports);
    void stand();
    void roll(const FwGuidancePorts& ports, float dt);
    void climb_out(const FwGuidancePorts& ports);
    void fly(const FwGuidancePorts& ports, float dt);
    void fly_goal(const FwGuidancePorts& ports);
    void land(const FwGuidancePorts& ports, float dt);
    void descend();
    void watch_height(float dt);
    void fly_by_sticks(const FwGuidancePorts& ports);
    void count_laps();
    void follow(const FwGuidancePorts& ports, const Path& path);
    float steer(float heading, float gain) const;
    float airspeed_or_trim(const FwGuidancePorts& ports) const;

    Stage stage_ = Stage::kGround;
    VehicleStatus::NavState nav_state_ = VehicleStatus::NavState::kHold;
    bool is_armed_ = false;
    Vector2 position_ = Vector2::Zero();
    Vector2 velocity_ = Vector2::Zero();
    Vector2 wind_ = Vector2::Zero();
    bool knows_wind_ = false;
    float altitude_ = 0.0F;  // above the origin of N
    float climb_ = 0.0F;
    float heading_ = 0.0F;
    float ground_ = 0.0F;  // its altitude

    GotoSetpoint goal_{};
    bool has_goal_ = false;
    bool is_done_ = false;
    bool is_take_off_ = false;  // the goal
    Path path_;
    float wanted_altitude_ = 0.0F;
    float sinks_s_ = 0.0F;  // below it, and cannot help it
    float bearing_from_centre_ = 0.0F;
    float turned_ = 0.0F;  // round the circle

    Vector2 start_ = Vector2::Zero();  // of the take-off
    float start_heading_ = 0.0F;
    float in_stage_s_ = 0.0F;
    float rotating_s_ = 0.0F;
    Landing landing_;
    float touchdown_heading_ = 0.0F;

    FixedWingLateralSetpoint lateral_{};
    FixedWingLongitudinalSetpoint longitudinal_{};
    TrajectorySetpoint setpoint_{};
    uint64_t last_us_ = 0;
};

}  // namespace stator::apps::fw_guidance
