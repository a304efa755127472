// The time between two steps of a node, in seconds.
#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>

namespace stator {

// From `last_us` to `now_us`, which is then the last. Within [shortest_s, longest_s], so that a
// gap, a repeated time stamp or one from before is no kick; the shortest for a time that runs
// backwards. longest_s is at most an hour: more than 2^32 us count as so many.
inline float seconds_since_last(uint64_t& last_us, uint64_t now_us, float shortest_s,
                                float longest_s) {
    constexpr uint64_t kMax_us = std::numeric_limits<uint32_t>::max();
    const uint64_t elapsed_us = now_us > last_us ? std::min(now_us - last_us, kMax_us) : 0;
    last_us = now_us;
    // 32 bits convert with one instruction, 64 with a call.
    const float seconds = static_cast<float>(static_cast<uint32_t>(elapsed_us)) * 1e-6F;
    return std::clamp(seconds, shortest_s, longest_s);
}

}  // namespace stator
