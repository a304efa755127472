// The fence: areas that include or exclude, a greatest distance from home, and a ceiling.
//
// A place is inside if it lies in at least one of the areas that include, where there is one, and
// in none that exclude. Without an area that includes, it lies within `radius` of home.
#pragma once

#include <array>
#include <cstdint>

#include "item.hpp"

namespace stator::apps::navigator {

// Commands of a fence's items.
enum class FenceKind : uint16_t {
    kPolygonInclusion = 5001,  // a vertex; parameter 1: how many the polygon has
    kPolygonExclusion = 5002,
    kCircleInclusion = 5003,  // parameter 1: the radius. Local: about home; z is the ceiling
    kCircleExclusion = 5004,
};

struct FenceLimits {
    float radius;  // m; 0: none
    float height;  // m above home; 0: none
};

class Geofence {
  public:
    static constexpr unsigned kMaxVertices = 128;
    static constexpr unsigned kMaxAreas = 16;
    static constexpr unsigned kMaxCrossings = 64;

    struct Breach {
        bool is_too_far = false;
        bool is_too_high = false;
        bool is_outside = false;  // the areas

        bool any() const { return is_too_far || is_too_high || is_outside; }
    };

    void clear();
    // The items of a fence, in order. False if one is none, or has no room.
    [[nodiscard]] bool add(const RawItem& item, const PlaceFrame& frame);
    bool is_whole() const { return vertices_left_ == 0; }

    // `usual`: where the fence itself has no such limit.
    FenceLimits limits(const FenceLimits& usual) const;
    Breach breach(const math::Vector3<float>& position_N, const math::Vector3<float>& home_N,
                  const FenceLimits& usual) const;
    // The straight way between two places that are inside leads out of the areas. A way that
    // crosses too many borders counts as one that does.
    bool is_left_between(const math::Vector3<float>& from_N, const math::Vector3<float>& to_N,
                         const math::Vector3<float>& home_N) const;

  private:
    struct Point {
        float x;
        float y;
    };
    struct Area {
        uint16_t first;  // of the vertices; of a circle: its middle
        uint16_t count;  // of the vertices; 1: a circle
        float radius;    // of a circle
        bool includes;
        bool is_about_home;
    };

    bool add_vertex(const RawItem& item, const PlaceFrame& frame, bool includes);
    bool add_circle(const RawItem& item, const PlaceFrame& frame, bool includes);
    bool contains(const Area& area, const Point& point, const Point& home) const;
    bool is_in_areas(const Point& point, const Point& home) const;
    Point middle(const Area& area, const Point& home) const {
        return area.is_about_home ? home : vertices_[area.first];
    }

    std::array<Point, kMaxVertices> vertices_{};
    std::array<Area, kMaxAreas> areas_{};
    unsigned vertex_count_ = 0;
    unsigned area_count_ = 0;
    unsigned vertices_left_ = 0;  // of the polygon that is being added
    bool has_inclusion_ = false;
    float ceiling_ = 0.0F;
};

}  // namespace stator::apps::navigator
