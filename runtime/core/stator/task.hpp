// What a generated task wrapper keeps between activations, and the rules that all wrappers share.
#pragma once

#include <cstdint>

#include "stator/port.hpp"

namespace stator {

// A periodic trigger. The timer counts and pends; the wrapper compares with what it has served, as
// a pending bit alone cannot say which trigger fired.
struct TimerState {
    Shared<uint32_t> fires;  // releases, modulo 2^32
    uint32_t served = 0;     // those that the task has served, modulo 2^32
    uint64_t released = 0;   // the whole counts: of the level that releases
    uint64_t seen = 0;       // and of the task
};
struct Timer {
    TimerState* state;
    uint32_t period_us;
    uint32_t offset_us;
    Pend pend;
};

// Nominal time of the newest release that was served.
inline uint64_t nominal_time_us(const TimerState& timer, uint32_t period_us, uint32_t offset_us) {
    return offset_us + period_us * (timer.seen - 1);
}

// For the level that releases: when the next one is due, and making it.
inline uint64_t next_release_us(const Timer& timer) {
    return timer.offset_us + timer.period_us * timer.state->released;
}
inline void release(const Timer& timer) {
    timer.state->released += 1;
    timer.state->fires.store(static_cast<uint32_t>(timer.state->released));
    set_pending(timer.pend);
}

// For the task: leaves out what was released up to count `start`.
inline void skip_to(TimerState& timer, uint32_t start) {
    timer.seen += start - timer.served;
    timer.served = start;
}

// True if there was a release since the last call.
inline bool served_now(TimerState& timer) {
    const uint32_t before = timer.served;
    skip_to(timer, timer.fires.load());
    return timer.served != before;
}

// A time that one level writes and lower ones read, in two words: read again if the upper one
// changed in between.
class SharedTime {
  public:
    uint64_t load() const {
        uint32_t low = 0;
        uint32_t high = high_.load();
        for (uint32_t before = ~high; before != high; high = high_.load()) {
            before = high;
            low = low_.load();
        }
        return (uint64_t{high} << 32) | low;
    }
    void store(uint64_t time_us) {
        high_.store(static_cast<uint32_t>(time_us >> 32));
        low_.store(static_cast<uint32_t>(time_us));
    }

  private:
    Shared<uint32_t> high_;
    Shared<uint32_t> low_;
};

// A device's line as its task sees it. `clock_us` is the clock at the newest entry of its vector.
struct LineState {
    Shared<uint32_t> fires;
    uint32_t served = 0;
    SharedTime clock_us;
    uint32_t early = 0;    // came before `min_interarrival`
    uint32_t dropped = 0;  // of these, not served: the one before was early too
    bool was_early = false;
};

// True if the trigger fired since the last call; advances what counts as served.
inline bool served_now(Shared<uint32_t>& fires, uint32_t& served) {
    const uint32_t count = fires.load();
    const bool fired = count != served;
    served = count;
    return fired;
}

// The assumption `min_interarrival` of a line: an early entry is counted, and refused only when the
// one before it was early too, as one late entry makes the next look early.
inline bool accept_line(LineState& line, uint64_t clock_us, uint32_t min_interarrival_us) {
    const bool first = line.fires.load() == 0 && line.dropped == 0;
    const bool early = !first && clock_us - line.clock_us.load() < min_interarrival_us;
    const bool drop = early && line.was_early;
    line.clock_us.store(clock_us);
    line.was_early = early;
    line.early += early ? 1U : 0U;
    line.dropped += drop ? 1U : 0U;
    return !drop;
}

// Whether a task runs in the present mode. Odd: it does. The switch counts up; the task's own
// wrapper sees the new number at its next entry and constructs its node anew, as a suspended job
// may still be using the old one.
struct ModeGate {
    Shared<uint32_t> epoch;
    uint32_t seen = 0;
};

constexpr uint64_t later(uint64_t a, uint64_t b) {
    return a < b ? b : a;
}

// Counts for `top`, the report and the proof's watch.
struct TaskCounters {
    uint64_t activations = 0;
    uint64_t lost_samples = 0;
};

}  // namespace stator
