// Which systems are heard on which line, and so where frames for them go.
#pragma once

#include <array>
#include <cstdint>

#include "stator/mavlink/frame.hpp"

namespace stator::apps::mavlink {

// A place is kept for a minute after the last frame; one that is new while all are in use is not
// noted, so floods of invented addresses do not push out those that are heard.
class Router {
  public:
    static constexpr unsigned kPlaces = 16;

    void hear(unsigned line, mav::Address from, uint64_t now_us);
    // Whether a frame of another line goes on to line `to`: what is for all does, what is for one
    // system or component only where that one was heard.
    bool goes_on(const mav::Frame& frame, mav::Address own, unsigned to) const;

  private:
    static constexpr uint32_t kKept = 60;  // of `stamp`

    struct Place {
        mav::Address address;
        uint8_t lines = 0;  // a bit for each
        uint32_t heard = 0;
    };
    // About a second.
    static uint32_t stamp(uint64_t now_us) { return static_cast<uint32_t>(now_us >> 20); }

    std::array<Place, kPlaces> places_{};
};

}  // namespace stator::apps::mavlink
