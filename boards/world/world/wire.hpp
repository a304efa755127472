// A simulated serial line between two machines: bytes take their time, one frame at a time in each
// direction; the far end may serve what came late, and faults cut the line or damage bytes.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <span>
#include <vector>

#include "stator/random.hpp"

namespace stator::world {

class Wire {
  public:
    static constexpr std::uint64_t kNever = UINT64_MAX;
    static constexpr unsigned kEnds = 2;

    struct Event {
        enum class Kind : std::uint8_t { kSent, kArrival };
        Kind kind;
        unsigned end;                     // where it happens
        std::vector<std::uint8_t> bytes;  // of an arrival
    };

    // `wake_up_us`: the longest time until an end serves a frame that has come; each is drawn.
    Wire(std::uint32_t baud, const std::array<std::uint32_t, kEnds>& wake_up_us,
         const math::Random& random)
        : baud_(baud), wake_up_us_(wake_up_us), random_(random) {}

    // From an end whose frame before is out.
    void send(unsigned end, std::span<const std::uint8_t> frame, std::uint64_t now_us);
    // Its machine has stopped: what it was sending ends here, and so does what was to come.
    void stop(unsigned end);
    // From now on. `noise`: the part of all bytes that is damaged.
    void set_faults(bool is_cut, double noise);

    std::uint64_t next_event_us() const;
    // The next event, which is due.
    Event take();

  private:
    struct Arrival {
        std::uint64_t at_us;
        std::vector<std::uint8_t> bytes;
    };
    struct Side {
        bool is_sending = false;
        std::uint64_t end_us = 0;
        std::vector<std::uint8_t> frame;
        std::deque<Arrival> arrivals;
    };
    static constexpr std::uint64_t kBitsOfByte = 10;
    static constexpr std::uint64_t kGap_us = 5;  // until the next frame begins

    Event finish(unsigned end);
    void damage(std::vector<std::uint8_t>& bytes);

    std::uint32_t baud_;
    std::array<std::uint32_t, kEnds> wake_up_us_;
    math::Random random_;
    std::array<Side, kEnds> sides_;
    bool is_cut_ = false;
    double noise_ = 0.0;
};

}  // namespace stator::world
