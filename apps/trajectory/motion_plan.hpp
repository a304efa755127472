// A smooth motion from any state to rest at a goal: it comes to rest from where it is, and leaves
// for the goal meanwhile.
#pragma once

#include "profile.hpp"
#include "stator/rotation.hpp"

namespace stator::apps::trajectory {

struct PathState {
    math::Vector3<float> position = math::Vector3<float>::Zero();
    math::Vector3<float> velocity = math::Vector3<float>::Zero();
    math::Vector3<float> acceleration = math::Vector3<float>::Zero();
};

// To rest from any state: the acceleration fades at the limit of jerk, and the velocity that is
// then left is taken away as by a SpeedUp.
class Stop {
  public:
    Stop() = default;
    Stop(const PathState& start, const ProfileLimits& limits);

    float duration() const { return duration_; }
    PathState at(float time) const;
    math::Vector3<float> rest() const { return at(duration_).position; }
    // What is taken away.
    const math::Vector3<float>& velocity() const { return velocity_; }

  private:
    PathState start_;
    float fade_time_ = 0.0F;
    math::Vector3<float> velocity_ = math::Vector3<float>::Zero();
    math::Vector3<float> direction_ = math::Vector3<float>::Zero();
    SpeedUp speed_up_;
    float duration_ = 0.0F;
};

// From rest to rest along a straight line, round a circle, or round an eight, which is
//
//     (A sin p, A/2 sin 2p)     p from 0 to 2 pi times the laps
//
// along its axis and across: 2A long and A wide. Gerono's curve; it is fastest in its middle.
class Leg {
  public:
    Leg() = default;  // stays
    static Leg line(const math::Vector3<float>& way, const ProfileLimits& limits);
    // Round a middle that lies at `bearing` + pi: `bearing` leads from there to where it begins.
    static Leg circle(float bearing, float radius, float turns, const ProfileLimits& limits);
    static Leg eight(float heading, float length, float laps, const ProfileLimits& limits);

    float duration() const { return profile_.duration(); }
    // Against where it begins.
    PathState at(float time) const;

  private:
    math::Vector3<float> axis_ = math::Vector3<float>::Zero();
    math::Vector3<float> across_ = math::Vector3<float>::Zero();
    float half_length_ = 0.0F;  // of an eight; 0: none
    float radius_ = 0.0F;       // of a circle; 0: none
    Profile profile_;
};

// The sum of both: with a leg that leads on, the corner is cut and the speed kept. A leg that leads
// back waits for the stop, as the sum would need twice the acceleration.
class MotionPlan {
  public:
    MotionPlan() = default;
    MotionPlan(const Stop& stop, const Leg& leg);

    float duration() const;
    PathState at(float time) const;

  private:
    Stop stop_;
    Leg leg_;
    float leg_start_ = 0.0F;
};

}  // namespace stator::apps::trajectory
