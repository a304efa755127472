// A flight from parameters: arms, takes off, hovers, lands, disarms. Source of the trajectory that
// position_control follows.
#pragma once

#include <cstdint>

#include "sequence_ports.hpp"
#include "straight_leg.hpp"

namespace stator::apps::sequence {

// Runs at a fixed period. Waits for a position, and for all motor controllers, before it arms.
// Where one of these goes on the ground it disarms and waits again; in flight it lands: straight
// down while there is a position, by velocity alone while there is none. Once disarmed after a
// landing it stays so.
class Sequence {
  public:
    void step(SequencePorts& ports);

  private:
    using Event = VehicleStatus::FailsafeEvent;
    enum class Phase { kWait, kSpoolUp, kClimb, kApproach, kHover, kLand, kDone };

    void take_position(const SequencePorts& ports, float dt);
    void begin(Phase phase);
    void begin_landing(const SequenceParams& params);
    Event what_forces_down() const;
    void advance(const SequenceParams& params, float dt);
    void wait(const SequenceParams& params);
    void spool_up(const SequenceParams& params);
    void climb(const SequenceParams& params, float dt);
    void approach(const SequenceParams& params, float dt);
    void land(const SequenceParams& params, float dt);
    void turn(const SequenceParams& params, float dt);
    bool has_touched_down(float dt);
    bool position_is_lost() const;
    bool is_ready() const { return bad_for_s_ == 0.0F && !motor_is_lost_; }

    TrajectorySetpoint setpoint(const SequenceParams& params) const;
    VehicleStatus status() const;

    Phase phase_ = Phase::kWait;
    float in_phase_s_ = 0.0F;
    StraightLeg leg_;
    float yaw_ = 0.0F;  // wanted
    float yaw_rate_ = 0.0F;

    // The newest good position.
    math::Vector3<float> position_N_ = math::Vector3<float>::Zero();
    float down_speed_ = 0.0F;
    float heading_ = 0.0F;
    float good_for_s_ = 0.0F;
    float bad_for_s_ = 0.0F;
    bool motor_is_lost_ = false;
    Event failsafe_ = Event::kNone;

    float ground_z_ = 0.0F;
    bool is_blind_ = false;  // lands without position
    float blind_left_s_ = 0.0F;
    float still_for_s_ = 0.0F;
    uint64_t last_us_ = 0;
};

}  // namespace stator::apps::sequence
