// Which item of a mission comes next: jumps, conditions, and what is done at once between places.
//
// Between two places stand items that are done when the first one is reached. From the first
// condition among them on they are done on the way to the second place, each when its condition
// holds; those that are left are done when that place is reached.
#pragma once

#include <array>
#include <cstdint>

#include "item_reader.hpp"

namespace stator::apps::navigator {

// What the sequence goes by.
struct Situation {
    math::Vector3<float> before_N;    // the newest place, which an item without one takes
    math::Vector3<float> position_N;  // of the vehicle
    float heading;
    float dt;
};

class Sequence {
  public:
    static constexpr unsigned kMaxJumps = 16;  // of a mission, with their repetitions

    enum class Next : uint8_t {
        kPlace,    // `item` is to be flown
        kWaiting,  // for a condition
        kMissing,  // for an item that is not there yet
        kOver,     // no item is left
    };
    struct Speeds {  // m/s; not a number: the trajectory's own
        float horizontal = math::canonical_nan<float>();
        float climb = math::canonical_nan<float>();
        float descent = math::canonical_nan<float>();
    };

    // From the first item on.
    void restart() { *this = Sequence(); }
    // With the place that was flown last, if it was not reached.
    void go_back_to_place() {
        if (is_under_way_) next_ = current_;
        beside_ = next_;
        is_under_way_ = false;
    }

    // When the newest place was reached: does what stands before the next one.
    Next take(ItemReader& reader, uint32_t id, unsigned count, const PlaceFrame& frame,
              const Situation& situation);
    // On the way: does what has become due. `is_there`: all that is left.
    void do_beside(ItemReader& reader, uint32_t id, const PlaceFrame& frame,
                   const Situation& situation, bool is_there);
    // With this item next, whatever was flown.
    void go_on_with(unsigned item) {
        next_ = current_ = beside_ = item;
        is_under_way_ = false;
    }
    void arrive() { is_under_way_ = false; }
    // Another mission took the place of this one: of this, nothing is left but the place.
    void forget() {
        beside_ = current_;
        jump_count_ = 0;
    }
    // Where an item without a place is.
    bool has_place() const { return has_place_; }

    const Item& item() const { return item_; }  // of the newest place
    unsigned current() const { return current_; }
    unsigned next() const { return next_; }
    const Speeds& speeds() const { return speeds_; }
    // True once after a change of speed.
    bool take_speed_change() {
        const bool changed = speed_has_changed_;
        speed_has_changed_ = false;
        return changed;
    }
    bool has_region() const { return has_region_; }
    const math::Vector3<float>& region_N() const { return region_N_; }
    // That a condition wants until the next place; not a number: none.
    float heading() const { return heading_; }

  private:
    struct Jump {
        uint16_t at;
        int32_t left;  // below 0: for ever
    };

    Next take_one(ItemReader& reader, uint32_t id, unsigned count, const PlaceFrame& frame,
                  const Situation& situation, bool& goes_on);
    // Whether a place follows in the window, with nothing but conditions and commands before.
    bool find_place(ItemReader& reader, uint32_t id, unsigned count, unsigned& place);
    void fly(unsigned index, const RawItem& raw, const PlaceFrame& frame,
             const Situation& situation);
    void execute(const RawItem& raw, const PlaceFrame& frame, const Situation& situation);
    bool holds(const RawItem& raw, const Situation& situation, bool has_place);
    void jump(unsigned at, const RawItem& raw, unsigned count);

    unsigned next_ = 0;
    unsigned current_ = 0;
    unsigned beside_ = 0;  // the next one to be done on the way, up to `current_`
    bool is_under_way_ = false;
    bool has_place_ = false;
    Item item_{.kind = ItemKind::kWaypoint,
               .position_N = math::Vector3<float>::Zero(),
               .param = {},
               .continues = true};
    float condition_s_ = 0.0F;  // since the condition at hand began
    bool has_begun_ = false;    // the condition at hand
    Speeds speeds_;
    bool speed_has_changed_ = false;
    bool has_region_ = false;
    math::Vector3<float> region_N_ = math::Vector3<float>::Zero();
    float heading_ = math::canonical_nan<float>();
    std::array<Jump, kMaxJumps> jumps_{};
    unsigned jump_count_ = 0;
};

}  // namespace stator::apps::navigator
