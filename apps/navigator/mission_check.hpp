// Whether a mission can be flown, item by item, as not all of it is at hand at once.
#pragma once

#include "geofence.hpp"
#include "messages/mission_result.hpp"
#include "sequence.hpp"

namespace stator::apps::navigator {

struct CheckLimits {
    float farthest;  // m from home
    FenceLimits fence;
};

class MissionCheck {
  public:
    using Fault = MissionResult::Fault;

    MissionCheck() = default;
    // From the first item on, about this home.
    explicit MissionCheck(const math::Vector3<float>& home_N)
        : home_N_(home_N), before_N_(home_N) {}

    unsigned next() const { return next_; }
    Fault fault() const { return fault_; }
    const math::Vector3<float>& home_N() const { return home_N_; }

    // The next item. Not to be called after a fault.
    void take(const RawItem& raw, unsigned count, const PlaceFrame& frame, const Geofence& fence,
              const CheckLimits& limits);

  private:
    Fault fault_of(const RawItem& raw, unsigned count, const PlaceFrame& frame,
                   const Geofence& fence, const CheckLimits& limits);
    Fault fault_of_place(const Item& item, const Geofence& fence, const CheckLimits& limits) const;
    bool stays_inside(const Item& item, const Geofence& fence, const CheckLimits& limits) const;

    math::Vector3<float> home_N_ = math::Vector3<float>::Zero();
    math::Vector3<float> before_N_ = math::Vector3<float>::Zero();
    unsigned next_ = 0;
    unsigned jumps_ = 0;
    Fault fault_ = Fault::kNone;
};

}  // namespace stator::apps::navigator
