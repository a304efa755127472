// Which frames count by their signatures, and the time that ours have.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "link.hpp"
#include "mavlink_ports.hpp"
#include "stator/mavlink/signature.hpp"

namespace stator::apps::mavlink {

// A frame that is signed and comes here has the right hash: its line has checked that, and knows
// the key. What is left is its time, which repeats nothing: within a stream (system, component and
// link) it grows, and a new stream is at most a minute behind us. The table of streams has an end:
// what is new while it is full is refused, so nobody pushes out those who are known.
//
// Our time is the greatest that was seen, and goes on with the clock. It never goes back, across
// restarts too: what is kept is a time that none of our frames has reached.
class Signing {
  public:
    static constexpr unsigned kStreams = 16;
    static constexpr uint64_t kSecond = 100'000;  // of the time of signatures

    // Once in each activation, before all frames. `signs`: frames must be signed.
    void step(bool signs, MavlinkPorts& ports);
    // Whether a frame of a line that checks signatures counts. `may_be_unsigned`: by its line.
    bool takes(const mav::Frame& frame, bool may_be_unsigned, uint64_t now_us);
    uint64_t time(uint64_t now_us) const { return offset_ + now_us / 10; }
    // Another key, which counts from this time on; none: forget it all.
    void restart(std::optional<uint64_t> time, uint64_t now_us);

  private:
    static constexpr uint64_t kOldest = 60 * kSecond;
    // Less than `kOldest`: a restart must not make us too new for others.
    static constexpr uint64_t kAhead = 40 * kSecond;
    static constexpr uint64_t kKeepsBefore = 10 * kSecond;
    static constexpr uint64_t kRetry_us = 1'000'000;

    struct Stream {
        mav::Address from;
        uint8_t link = 0;
        bool is_used = false;
        uint64_t time = 0;
    };

    bool takes_time(const mav::Frame& frame, uint64_t now_us);
    void see(uint64_t time, uint64_t now_us) {
        if (time > this->time(now_us)) offset_ = time - now_us / 10;
    }
    void keep(MavlinkPorts& ports);

    std::array<Stream, kStreams> streams_{};
    uint64_t offset_ = 0;
    uint64_t bound_ = 0;  // as it is kept
    uint64_t kept_us_ = 0;
    bool forgets_ = false;
};

}  // namespace stator::apps::mavlink
