// What a generated task wrapper keeps between activations, and the rules that all wrappers share.
#pragma once

#include <atomic>
#include <cstdint>

#include "stator/task_counters.hpp"
#include "stator/topic.hpp"

namespace stator {

// A periodic trigger. The timer counts and pends; the wrapper compares with what it has served, as
// a pending bit alone cannot say which trigger fired. Times are sums of periods: nothing wraps.
struct TimerState {
    Shared<uint32_t> fires;    // releases, modulo 2^32
    uint32_t served = 0;       // those that the task has served, modulo 2^32
    uint64_t released_us = 0;  // all periods released: of the level that releases
    uint64_t served_us = 0;    // and served: of the task
    uint32_t missed = 0;       // releases that were served together with a later one
};
struct Timer {
    TimerState* state;
    uint32_t period_us;
    uint32_t offset_us;
    Pend pend;
};

// Nominal time of the newest release that was served; the first one is at the offset.
inline uint64_t nominal_time_us(const TimerState& timer, uint32_t period_us, uint32_t offset_us) {
    return timer.served_us + offset_us - period_us;
}

// For the level that releases: when the next one is due, and making it.
inline uint64_t next_release_us(const Timer& timer) {
    return timer.state->released_us + timer.offset_us;
}
inline void release(const Timer& timer) {
    timer.state->released_us += timer.period_us;
    timer.state->fires.store(timer.state->fires.load() + 1);
    set_pending(timer.pend);
}

// For the task: leaves out what was released up to count `start`.
inline void skip_to(TimerState& timer, uint32_t start, uint32_t period_us) {
    timer.served_us += uint64_t{start - timer.served} * period_us;
    timer.served = start;
}

// True if there was a release since the last call.
inline bool served_now(TimerState& timer, uint32_t period_us) {
    const uint32_t count = timer.fires.load();
    if (count == timer.served) return false;
    timer.missed += count - timer.served - 1;
    skip_to(timer, count, period_us);
    return true;
}

// The assumption `min_interarrival` of a line, checked.
struct EntryState {
    uint64_t due_us = 0;   // earliest time of the next one that is not early
    uint32_t early = 0;    // came before
    uint32_t dropped = 0;  // of these, not served: the one before was early too
    bool was_early = false;
};

// An early entry is refused only when the one before it was early too, as one late entry makes the
// next look early.
inline bool is_refused(const EntryState& line, uint64_t clock_us) {
    return line.was_early && clock_us < line.due_us;
}
inline void note_entry(EntryState& line, uint64_t clock_us, uint32_t min_interarrival_us) {
    const bool early = clock_us < line.due_us;
    line.dropped += early && line.was_early ? 1U : 0U;
    line.early += early ? 1U : 0U;
    line.was_early = early;
    line.due_us = clock_us + min_interarrival_us;
}

// A device's line as its task sees it. `clock_us` is the clock at the newest entry of its vector.
struct LineState : EntryState {
    Shared<uint32_t> fires;
    uint32_t served = 0;
    SharedTime clock_us;
};

// True if the trigger fired since the last call; advances what counts as served.
inline bool served_now(const Shared<uint32_t>& fires, uint32_t& served) {
    const uint32_t count = fires.load();
    const bool fired = count != served;
    served = count;
    return fired;
}

// At the entry of a line's vector: notes it for its task. False: refused.
inline bool accept_line(LineState& line, uint64_t clock_us, uint32_t min_interarrival_us) {
    const bool is_served = !is_refused(line, clock_us);
    note_entry(line, clock_us, min_interarrival_us);
    line.clock_us.store(clock_us);
    return is_served;
}

// Whether a task runs in the present mode. Odd: it does. The switch counts up; the task's own
// wrapper sees the new number at its next entry and constructs its node anew, as a suspended job
// may still be using the old one.
struct ModeGate {
    Shared<uint32_t> epoch;
    uint32_t seen = 0;
};

// What a generated task asks of a node's class.
template <class Node, class Ports>
concept Steps = requires(Node& node, Ports& ports) {
    node.step(ports);
};

constexpr uint64_t later(uint64_t a, uint64_t b) {
    return a < b ? b : a;
}

// Publications that were refused, as they exceeded the `burst` of their output; of all tasks.
struct RefusedPublications {
    std::atomic<uint32_t> count{0};
    std::atomic<const char*> newest{nullptr};  // NODE.OUTPUT
};
inline RefusedPublications refused_publications;

[[gnu::cold, gnu::noinline]] inline void note_refused(TaskCounters& counters, const char* output,
                                                      uint32_t refused) {
    // As in `add_to_counter` of an executor: the monitor may look meanwhile.
    __atomic_store_n(&counters.lost_samples, counters.lost_samples + refused, __ATOMIC_RELAXED);
    refused_publications.newest.store(output, std::memory_order_relaxed);
    refused_publications.count.fetch_add(refused, std::memory_order_release);
}
// Behind the step, of each output. `output`: NODE.OUTPUT.
inline void count_refused(TaskCounters& counters, const char* output, uint32_t refused) {
    if (refused != 0) [[unlikely]] {
        note_refused(counters, output, refused);
    }
}

}  // namespace stator
