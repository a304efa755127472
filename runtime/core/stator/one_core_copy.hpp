// A copy of a topic's newest sample, for a reader that has no slot planned.
#pragma once

#include <cstring>

#include "stator/one_core_topic.hpp"

namespace stator {

// Copies at most `bytes` and says the sample's number; false: there is none. Without a pin: a
// publisher may write meanwhile, but its commit tells it. Gives up after some tries, as if there
// were no sample. Context: below all publishers, or at their level.
inline bool copy_newest_below(const Topic& topic, uint8_t* to, size_t bytes, uint32_t& number) {
    constexpr unsigned kMaxTries = 4;
    for (unsigned i = 0; i < kMaxTries; ++i) {
        const uint32_t head = head_of(topic).load();
        Pin pin;
        if (!take_latest(topic, 0, pin, false)) return false;
        std::memcpy(to, sample_of(topic, pin), bytes);
        if (head_of(topic).load() != head) continue;
        number = head;
        return true;
    }
    return false;
}

}  // namespace stator
