// Which systems are heard on which line.
#include "router.hpp"

#include <algorithm>

#include "mavlink/messages.hpp"

namespace stator::apps::mavlink {

namespace {

constexpr uint32_t kRadio = 166;  // RADIO, the older form of RADIO_STATUS

// Between the two ends of a line, and nobody else's.
bool is_private(uint32_t id) {
    return id == mav::SetupSigning::kId || id == mav::RadioStatus::kId || id == kRadio;
}

}  // namespace

void Router::hear(unsigned line, mav::Address from, uint64_t now_us) {
    Place* chosen = nullptr;
    for (Place& place : places_) {
        if (place.lines != 0 && place.address == from) {
            chosen = &place;
            break;
        }
        const bool is_free = place.lines == 0 || stamp(now_us) - place.heard > kKept;
        if (chosen == nullptr && is_free) chosen = &place;
    }
    if (chosen == nullptr) return;
    if (!(chosen->address == from)) *chosen = {.address = from};
    chosen->lines |= static_cast<uint8_t>(1U << line);
    chosen->heard = stamp(now_us);
}

bool Router::goes_on(const mav::Frame& frame, mav::Address own, unsigned to) const {
    if (is_private(frame.id)) return false;
    const mav::Address target = target_of(frame);
    // What is typed for nobody by name is typed for the console at the end of that line.
    if (target.system == 0) return frame.id != mav::SerialControl::kId;
    if (target == own) return false;
    return std::ranges::any_of(places_, [&](const Place& place) {
        return (place.lines >> to & 1U) != 0 && place.address.system == target.system &&
               (target.component == 0 || place.address.component == target.component);
    });
}

}  // namespace stator::apps::mavlink
