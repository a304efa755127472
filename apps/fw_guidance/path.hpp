// What an aeroplane flies along: a straight line, or a circle.
#pragma once

#include "npfg.hpp"
#include "stator/rotation.hpp"

namespace stator::apps::fw_guidance {

inline Vector2 unit(float bearing) {
    const math::SinCos<float> at = math::sincos(bearing);
    return {at.cos, at.sin};
}

class Path {
  public:
    Path() = default;
    // Without a length, along `bearing`.
    static Path line(const Vector2& from, const Vector2& to, float bearing) {
        Path path;
        path.end_ = to;
        path.tangent_ = math::normalized(Vector2(to - from), unit(bearing));
        return path;
    }
    // `radius` above 0 turns right.
    static Path circle(const Vector2& centre, float radius) {
        Path path;
        path.end_ = centre;
        path.radius_ = radius;
        return path;
    }

    bool is_circle() const { return radius_ != 0.0F; }
    const Vector2& end() const { return end_; }  // of a circle: its centre
    const Vector2& tangent() const { return tangent_; }
    float radius() const { return radius_; }
    // Of a line: how far its end is ahead. Below 0 it is behind.
    float left(const Vector2& position) const { return (end_ - position).dot(tangent_); }

    PathPoint nearest(const Vector2& position) const {
        if (!is_circle()) {
            return {.position = end_ - left(position) * tangent_,
                    .tangent = tangent_,
                    .curvature = 0.0F};
        }
        const Vector2 out = math::normalized(Vector2(position - end_), Vector2(1.0F, 0.0F));
        const Vector2 clockwise(-out.y(), out.x());
        return {.position = end_ + math::abs(radius_) * out,
                .tangent = radius_ > 0.0F ? clockwise : Vector2(-clockwise),
                .curvature = 1.0F / radius_};
    }

  private:
    Vector2 end_ = Vector2::Zero();
    Vector2 tangent_ = Vector2(1.0F, 0.0F);
    float radius_ = 0.0F;
};

}  // namespace stator::apps::fw_guidance
