// The fence.
#include "geofence.hpp"

namespace stator::apps::navigator {

using math::Vector3;

namespace {

constexpr unsigned kLeastVertices = 3;

// Where a way crosses borders, as parts of its length.
class Crossings {
  public:
    void add(float part) {
        if (!(part > 0.0F && part < 1.0F)) return;
        if (count_ == parts_.size()) {
            is_full_ = true;
            return;
        }
        parts_[count_++] = part;
    }
    bool is_full() const { return is_full_; }
    // In order, with both ends of the way.
    unsigned sort() {
        parts_[count_++] = 0.0F;
        parts_[count_++] = 1.0F;
        // Not by std::sort, which calls itself: the stack of an image has a bound.
        const auto end = parts_.begin() + count_;
        std::make_heap(parts_.begin(), end);
        std::sort_heap(parts_.begin(), end);
        return count_;
    }
    float at(unsigned i) const { return parts_[i]; }

  private:
    std::array<float, Geofence::kMaxCrossings + 2> parts_{};
    unsigned count_ = 0;
    bool is_full_ = false;
};

bool is_polygon(FenceKind kind) {
    return kind == FenceKind::kPolygonInclusion || kind == FenceKind::kPolygonExclusion;
}

}  // namespace

void Geofence::clear() {
    *this = Geofence();
}

bool Geofence::add(const RawItem& item, const PlaceFrame& frame) {
    const auto kind = static_cast<FenceKind>(item.command);
    const bool includes =
        kind == FenceKind::kPolygonInclusion || kind == FenceKind::kCircleInclusion;
    if (is_polygon(kind)) return add_vertex(item, frame, includes);
    if (kind == FenceKind::kCircleInclusion || kind == FenceKind::kCircleExclusion) {
        return add_circle(item, frame, includes);
    }
    return false;
}

bool Geofence::add_vertex(const RawItem& item, const PlaceFrame& frame, bool includes) {
    const Vector3<float> at = frame.place(item, frame.home_N());
    if (vertex_count_ == kMaxVertices || !math::is_finite(at.x() + at.y())) return false;
    if (vertices_left_ == 0) {
        const auto count = math::saturate<unsigned>(item.param[0]);
        if (area_count_ == kMaxAreas || count < kLeastVertices || count > kMaxVertices)
            return false;
        areas_[area_count_++] = {.first = static_cast<uint16_t>(vertex_count_),
                                 .count = static_cast<uint16_t>(count),
                                 .radius = 0.0F,
                                 .includes = includes,
                                 .is_about_home = false};
        vertices_left_ = count;
        has_inclusion_ = has_inclusion_ || includes;
    }
    if (areas_[area_count_ - 1].includes != includes) return false;
    vertices_[vertex_count_++] = {at.x(), at.y()};
    --vertices_left_;
    return true;
}

// A circle about home with a radius of 0 gives the ceiling alone.
bool Geofence::add_circle(const RawItem& item, const PlaceFrame& frame, bool includes) {
    const bool is_about_home = item.frame == Frame::kLocal;
    const float radius = item.param[0];
    if (vertices_left_ != 0 || !(radius >= 0.0F)) return false;
    if (is_about_home && math::is_finite(item.z) && item.z < 0.0F) ceiling_ = -item.z;
    if (is_about_home && radius == 0.0F) return true;
    const Vector3<float> at = frame.place(item, frame.home_N());
    const bool has_room = vertex_count_ < kMaxVertices && area_count_ < kMaxAreas;
    if (!has_room || !(radius > 0.0F) || !math::is_finite(at.x() + at.y())) return false;
    areas_[area_count_++] = {.first = static_cast<uint16_t>(vertex_count_),
                             .count = 1,
                             .radius = radius,
                             .includes = includes,
                             .is_about_home = is_about_home};
    vertices_[vertex_count_++] = {at.x(), at.y()};
    has_inclusion_ = has_inclusion_ || includes;
    return true;
}

FenceLimits Geofence::limits(const FenceLimits& usual) const {
    return {.radius = has_inclusion_ ? 0.0F : usual.radius,
            .height = ceiling_ > 0.0F ? ceiling_ : usual.height};
}

// Of a polygon: whether a ray to the east crosses its border an odd number of times.
bool Geofence::contains(const Area& area, const Point& point, const Point& home) const {
    if (area.count == 1) {
        const Point center = middle(area, home);
        return math::square(point.x - center.x) + math::square(point.y - center.y) <=
               math::square(area.radius);
    }
    bool is_inside = false;
    for (unsigned i = 0; i < area.count; ++i) {
        const Point& a = vertices_[area.first + i];
        const Point& b = vertices_[area.first + (i + 1) % area.count];
        if ((a.x > point.x) == (b.x > point.x)) continue;
        const float y = a.y + (b.y - a.y) * (point.x - a.x) / (b.x - a.x);
        if (point.y < y) is_inside = !is_inside;
    }
    return is_inside;
}

bool Geofence::is_in_areas(const Point& point, const Point& home) const {
    bool is_included = !has_inclusion_;
    for (unsigned i = 0; i < area_count_; ++i) {
        const Area& area = areas_[i];
        if (area.includes && is_included) continue;
        if (!contains(area, point, home)) continue;
        if (!area.includes) return false;
        is_included = true;
    }
    return is_included;
}

Geofence::Breach Geofence::breach(const Vector3<float>& position_N, const Vector3<float>& home_N,
                                  const FenceLimits& usual) const {
    const FenceLimits limit = limits(usual);
    const Vector3<float> from_home = position_N - home_N;
    const float away = math::norm(from_home.head<2>());
    const Point point{position_N.x(), position_N.y()};
    return {.is_too_far = limit.radius > 0.0F && away > limit.radius,
            .is_too_high = limit.height > 0.0F && -from_home.z() > limit.height,
            .is_outside = area_count_ != 0 && !is_in_areas(point, {home_N.x(), home_N.y()})};
}

// Between two borders the way is all inside or all outside: its middle says which.
bool Geofence::is_left_between(const Vector3<float>& from_N, const Vector3<float>& to_N,
                               const Vector3<float>& home_N) const {
    if (area_count_ == 0) return false;
    const Point home{home_N.x(), home_N.y()};
    const Point way{to_N.x() - from_N.x(), to_N.y() - from_N.y()};
    Crossings crossings;
    for (unsigned i = 0; i < area_count_; ++i) {
        const Area& area = areas_[i];
        if (area.count == 1) {
            // |from + t way - center|^2 = r^2
            const Point center = middle(area, home);
            const Point from{from_N.x() - center.x, from_N.y() - center.y};
            const float a = way.x * way.x + way.y * way.y;
            const float b = from.x * way.x + from.y * way.y;
            const float c = from.x * from.x + from.y * from.y - math::square(area.radius);
            const float root2 = b * b - a * c;
            if (!(a > 0.0F && root2 > 0.0F)) continue;
            const float root = math::sqrt(root2);
            crossings.add((-b - root) / a);
            crossings.add((-b + root) / a);
            continue;
        }
        for (unsigned k = 0; k < area.count; ++k) {
            const Point& p = vertices_[area.first + k];
            const Point& q = vertices_[area.first + (k + 1) % area.count];
            const Point edge{q.x - p.x, q.y - p.y};
            const Point to{p.x - from_N.x(), p.y - from_N.y()};
            const float across = way.x * edge.y - way.y * edge.x;
            if (across == 0.0F) continue;
            const float along_edge = (to.x * way.y - to.y * way.x) / across;
            if (along_edge < 0.0F || along_edge > 1.0F) continue;
            crossings.add((to.x * edge.y - to.y * edge.x) / across);
        }
    }
    if (crossings.is_full()) return true;
    const unsigned count = crossings.sort();
    for (unsigned i = 0; i + 1 < count; ++i) {
        const float part = 0.5F * (crossings.at(i) + crossings.at(i + 1));
        const Point point{from_N.x() + part * way.x, from_N.y() + part * way.y};
        // Two borders at one place: a way along a common edge does not lead out.
        if (crossings.at(i + 1) - crossings.at(i) > 1e-6F && !is_in_areas(point, home)) return true;
    }
    return false;
}

}  // namespace stator::apps::navigator
