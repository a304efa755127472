// The approach of an aeroplane: round a circle down to the height of the approach, off it along its
// tangent, down a straight slope, flare, and roll to rest.
#pragma once

#include "path.hpp"

namespace stator::apps::fw_guidance {

struct LandingPlan {
    Vector2 place = Vector2::Zero();  // of the touchdown
    float heading = 0.0F;
    float slope = 0.0F;          // rad
    float height = 0.0F;         // m above the ground, at which the slope begins
    float radius = 0.0F;         // m, of the circle; above 0 turns right
    float flare_height = 1.0F;   // m
    float flare_sink = 0.4F;     // m/s, at the touchdown
    float ground_speed = 14.0F;  // m/s, there
};

struct LandingState {
    Vector2 position;
    Vector2 velocity;
    float height;  // above the ground
    float climb;   // m/s
};

class Landing {
  public:
    enum class Phase { kCircle, kSlope, kFlare, kRoll };

    void begin(const LandingPlan& plan);
    // Moves on to the phase that is due. A slope that is missed leads round again.
    void update(const LandingState& state, float dt);

    Phase phase() const { return phase_; }
    const Path& path() const { return phase_ == Phase::kCircle ? circle_ : final_; }
    const LandingPlan& plan() const { return plan_; }
    // Above the ground: of the circle, or the slope at this place.
    float height_at(const Vector2& position) const;
    // Of the flare: that of the slope at its height, flare_sink on the ground,
    // and more where the ground is lower than it should be.
    float sink_at(float height) const;
    unsigned go_arounds() const { return go_arounds_; }

  private:
    bool leaves_circle(const LandingState& state) const;
    bool misses(const LandingState& state) const;

    LandingPlan plan_{};
    Path circle_;
    Path final_;
    Phase phase_ = Phase::kCircle;
    float still_s_ = 0.0F;
    unsigned go_arounds_ = 0;
};

}  // namespace stator::apps::fw_guidance
