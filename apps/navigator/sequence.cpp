// Which item of a mission comes next.
#include "sequence.hpp"

namespace stator::apps::navigator {

using math::Vector3;

namespace {

constexpr float kNaN = math::canonical_nan<float>();
constexpr float kDegree = math::kPi<float> / 180.0F;
// Items in one activation: jumps that lead round without a place end in the next one.
constexpr unsigned kMostAtOnce = 16;
constexpr float kTurned = 0.1F;  // rad
constexpr float kLongestTurn_s = 10.0F;
constexpr unsigned kRegionNone = 0;
constexpr unsigned kRegionNextPlace = 1;

// As MAVLink has it: not above 0 but for "as usual" means no change.
void change(float& speed, float value) {
    constexpr float kAsUsual = -2.0F;
    if (value == kAsUsual) speed = kNaN;
    if (value > 0.0F) speed = value;
}

}  // namespace

Sequence::Next Sequence::take(ItemReader& reader, uint32_t id, unsigned count,
                              const PlaceFrame& frame, const Situation& situation) {
    bool goes_on = true;
    Next result = Next::kWaiting;
    for (unsigned i = 0; i < kMostAtOnce && goes_on; ++i) {
        result = take_one(reader, id, count, frame, situation, goes_on);
    }
    return result;
}

Sequence::Next Sequence::take_one(ItemReader& reader, uint32_t id, unsigned count,
                                  const PlaceFrame& frame, const Situation& situation,
                                  bool& goes_on) {
    goes_on = false;
    if (next_ >= count) return Next::kOver;
    const auto raw = reader.item(ItemReader::List::kMission, id, next_);
    if (!raw) return Next::kMissing;
    if (is_flown(raw->command)) {
        beside_ = next_;
        fly(next_, *raw, frame, situation);
        return Next::kPlace;
    }
    if (is_condition(raw->command)) {
        unsigned place = 0;
        if (find_place(reader, id, count, place)) {
            const auto there = reader.item(ItemReader::List::kMission, id, place);
            if (!there) return Next::kMissing;
            beside_ = next_;
            fly(place, *there, frame, situation);
            return Next::kPlace;
        }
        if (!holds(*raw, situation, false)) return Next::kWaiting;
    }
    goes_on = true;
    const unsigned at = next_++;
    if (static_cast<ItemKind>(raw->command) == ItemKind::kJump) {
        jump(at, *raw, count);
    } else {
        execute(*raw, frame, situation);
    }
    return Next::kWaiting;
}

bool Sequence::find_place(ItemReader& reader, uint32_t id, unsigned count, unsigned& place) {
    for (place = next_ + 1; place < count && place < next_ + kMostAtOnce; ++place) {
        const auto raw = reader.item(ItemReader::List::kMission, id, place);
        if (!raw || static_cast<ItemKind>(raw->command) == ItemKind::kJump) return false;
        if (is_flown(raw->command)) return true;
    }
    return false;
}

void Sequence::fly(unsigned index, const RawItem& raw, const PlaceFrame& frame,
                   const Situation& situation) {
    current_ = index;
    next_ = index + 1;
    item_ = item_of(raw, frame, situation.before_N);
    is_under_way_ = has_place_ = true;
    has_begun_ = false;
    heading_ = kNaN;
}

void Sequence::do_beside(ItemReader& reader, uint32_t id, const PlaceFrame& frame,
                         const Situation& situation, bool is_there) {
    for (unsigned i = 0; i < kMostAtOnce && beside_ < current_; ++i) {
        const auto raw = reader.item(ItemReader::List::kMission, id, beside_);
        if (!raw) return;
        if (is_condition(raw->command)) {
            if (!is_there && !holds(*raw, situation, true)) return;
            has_begun_ = false;
        } else {
            execute(*raw, frame, situation);
        }
        ++beside_;
    }
}

// Begins the condition when it is asked for the first time.
bool Sequence::holds(const RawItem& raw, const Situation& situation, bool has_place) {
    const auto kind = static_cast<ItemKind>(raw.command);
    condition_s_ = has_begun_ ? condition_s_ + situation.dt : 0.0F;
    if (kind == ItemKind::kConditionYaw && !has_begun_) {
        const bool is_relative = raw.param[3] == 1.0F;
        const float turn = raw.param[2] < 0.0F && is_relative ? -raw.param[0] : raw.param[0];
        heading_ = math::wrap_pi(kDegree * turn + (is_relative ? situation.heading : 0.0F));
    }
    has_begun_ = true;
    bool is_met = true;
    if (kind == ItemKind::kConditionDelay) is_met = !(condition_s_ < raw.param[0]);
    if (kind == ItemKind::kConditionDistance && has_place) {
        const Vector3<float> way = item_.position_N - situation.position_N;
        is_met = !(math::norm(way.head<2>()) > raw.param[0]);
    }
    if (kind == ItemKind::kConditionYaw && math::is_finite(heading_ + situation.heading)) {
        const float left = math::abs(math::wrap_pi(heading_ - situation.heading));
        is_met = left < kTurned || condition_s_ > kLongestTurn_s;
    }
    if (is_met) has_begun_ = false;
    return is_met;
}

void Sequence::execute(const RawItem& raw, const PlaceFrame& frame, const Situation& situation) {
    switch (static_cast<ItemKind>(raw.command)) {
        case ItemKind::kChangeSpeed: {
            const auto type = math::saturate<unsigned>(raw.param[0]);
            if (type == 2) {
                change(speeds_.climb, raw.param[1]);
            } else if (type == 3) {
                change(speeds_.descent, raw.param[1]);
            } else {
                change(speeds_.horizontal, raw.param[1]);
            }
            speed_has_changed_ = true;
            return;
        }
        case ItemKind::kRegionOfInterest:
        case ItemKind::kRegionOfInterestNav: {
            const auto mode = math::saturate<unsigned>(raw.param[0]);
            has_region_ = mode != kRegionNone && mode != kRegionNextPlace;
            break;
        }
        case ItemKind::kRegionOfInterestLocation:
            has_region_ = true;
            break;
        case ItemKind::kRegionOfInterestNone:
            has_region_ = false;
            return;
        default:
            return;
    }
    if (!has_region_) return;
    region_N_ = frame.place(raw, situation.before_N);
    has_region_ = math::is_finite(region_N_.x() + region_N_.y());
}

// A jump that is not in the table begins with all its repetitions; one that is used up begins
// again when it is met the next time, as in a loop around it.
void Sequence::jump(unsigned at, const RawItem& raw, unsigned count) {
    const auto target = math::saturate<unsigned>(raw.param[0]);
    if (target >= count || !(raw.param[1] != 0.0F)) return;
    auto* const end = jumps_.begin() + jump_count_;
    auto* entry = std::find_if(jumps_.begin(), end, [=](const Jump& j) { return j.at == at; });
    if (entry == end) {
        if (jump_count_ == kMaxJumps) return;
        ++jump_count_;
        *entry = {.at = static_cast<uint16_t>(at), .left = math::saturate<int32_t>(raw.param[1])};
    }
    if (entry->left == 0) {
        *entry = jumps_[--jump_count_];
        return;
    }
    if (entry->left > 0) --entry->left;
    next_ = target;
}

}  // namespace stator::apps::navigator
