// The approach of an aeroplane.
#include "landing.hpp"

namespace stator::apps::fw_guidance {

namespace {

constexpr float kHeightOff = 3.0F;     // m, with which the slope may begin
constexpr float kCourseOff = 0.97F;    // cosine of 14 deg
constexpr float kTrackOff = 12.0F;     // m
constexpr float kMissedTrack = 10.0F;  // m, low on the slope
constexpr float kMissedHeight = 8.0F;  // m above the slope
constexpr float kLow = 10.0F;          // m
constexpr float kPast = 80.0F;         // m behind the place, still in the air
constexpr float kStill = 0.2F;         // m/s; the ground stops the sink of a flare
// How long: a gust does that, too, but seldom just above the ground.
constexpr float kStillLow_s = 0.3F;
constexpr float kStill_s = 1.5F;
constexpr float kPush = 0.3F;     // 1/s
constexpr float kVeryLow = 0.7F;  // m
constexpr unsigned kMostGoArounds = 3;

}  // namespace

void Landing::begin(const LandingPlan& plan) {
    plan_ = plan;
    phase_ = Phase::kCircle;
    still_s_ = 0.0F;
    const Vector2 along = unit(plan.heading);
    const Vector2 right(-along.y(), along.x());
    // The slope leads to a point in front of the place, as a flare reaches further than the slope:
    // h' = -sink_at(h) from flare_height to 0.
    const float steep = math::tan(plan.slope);
    const float above = math::max(plan.ground_speed * steep - plan.flare_sink, 0.01F);
    const float time = plan.flare_height / above * math::log(1.0F + above / plan.flare_sink);
    const float further = plan.ground_speed * time - plan.flare_height / steep;
    const Vector2 aim = plan.place - math::max(further, 0.0F) * along;
    const Vector2 start = aim - plan.height / steep * along;
    circle_ = Path::circle(start + plan.radius * right, plan.radius);
    final_ = Path::line(start, aim, plan.heading);
}

float Landing::height_at(const Vector2& position) const {
    if (phase_ == Phase::kCircle) return plan_.height;
    return math::min(plan_.height, final_.left(position) * math::tan(plan_.slope));
}

float Landing::sink_at(float height) const {
    const float part = math::clamp(height / plan_.flare_height, 0.0F, 1.0F);
    const float above = plan_.ground_speed * math::tan(plan_.slope) - plan_.flare_sink;
    // Lower than the ground should be, it pushes on.
    const float pushed = kPush * math::max(-height, 0.0F);
    return plan_.flare_sink + part * math::max(above, 0.0F) + pushed;
}

bool Landing::leaves_circle(const LandingState& state) const {
    const Vector2 course = math::normalized(state.velocity);
    const Vector2 ahead = final_.end() - state.position;
    const bool is_behind_start =
        ahead.dot(final_.tangent()) > 0.8F * plan_.height / math::tan(plan_.slope);
    const float off = math::abs(cross(final_.tangent(), Vector2(-ahead)));
    return math::abs(state.height - plan_.height) < kHeightOff && off < kTrackOff &&
           course.dot(final_.tangent()) > kCourseOff && is_behind_start;
}

bool Landing::misses(const LandingState& state) const {
    if (go_arounds_ >= kMostGoArounds) return false;
    const float left = final_.left(state.position);
    const float off = math::abs(cross(final_.tangent(), Vector2(state.position - final_.end())));
    const bool is_high = state.height - height_at(state.position) > kMissedHeight;
    return (state.height < kLow && off > kMissedTrack) || (left < 0.0F && is_high) || left < -kPast;
}

void Landing::update(const LandingState& state, float dt) {
    switch (phase_) {
        case Phase::kCircle:
            if (leaves_circle(state)) phase_ = Phase::kSlope;
            // It cannot keep the height of the circle: down where it is.
            if (state.height < plan_.flare_height) phase_ = Phase::kFlare;
            return;
        case Phase::kSlope:
            if (misses(state)) {
                ++go_arounds_;
                phase_ = Phase::kCircle;
            } else if (state.height < plan_.flare_height) {
                phase_ = Phase::kFlare;
                still_s_ = 0.0F;
            }
            return;
        case Phase::kFlare:
            // It sinks at flare_sink at least until something holds it.
            still_s_ = math::abs(state.climb) < kStill ? still_s_ + dt : 0.0F;
            if (still_s_ >= (state.height < kVeryLow ? kStillLow_s : kStill_s)) {
                phase_ = Phase::kRoll;
            }
            return;
        case Phase::kRoll:
            return;
    }
}

}  // namespace stator::apps::fw_guidance
