// Motion along a line of given length, from rest to rest, with limited speed, acceleration and
// jerk: the double S of Biagiotti and Melchiorri, Trajectory Planning for Automatic Machines and
// Robots, 2008, section 3.4, with equal limits both ways.
#pragma once

namespace stator::apps::trajectory {

struct ProfileLimits {
    float speed;
    float acceleration;
    float jerk;
};

struct Along {
    float distance = 0.0F;
    float speed = 0.0F;
    float acceleration = 0.0F;
};

// From rest to a speed: the acceleration rises, stays, and falls.
class SpeedUp {
  public:
    SpeedUp() = default;
    // All limits above 0.
    explicit SpeedUp(const ProfileLimits& limits);

    float duration() const { return duration_; }
    float speed() const { return speed_; }
    // At any time from 0 on; after `duration` it goes on at constant speed.
    Along at(float time) const;

  private:
    float speed_ = 0.0F;
    float jerk_ = 0.0F;
    float jerk_time_ = 0.0F;
    float duration_ = 0.0F;
};

class Profile {
  public:
    Profile() = default;
    // `length` >= 0, all limits above 0.
    Profile(float length, const ProfileLimits& limits);

    float duration() const { return duration_; }
    // Before the start it rests there, behind the end at the end.
    Along at(float time) const;

  private:
    float length_ = 0.0F;
    SpeedUp speed_up_;
    float duration_ = 0.0F;
};

}  // namespace stator::apps::trajectory
