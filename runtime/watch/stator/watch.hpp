// Life signs: tasks that must be activated at least so often, whatever happens to the rest.
//
// Checked by one monitor that is less urgent than every task, so that it runs only when all others
// have come to their ends. A task that was silent for longer than its window is counted; while one
// is silent, the watchdog is not kicked.
#pragma once

#include <cstdint>

#include "stator/events.hpp"
#include "stator/task.hpp"

namespace stator {

struct WatchState {
    uint64_t since_us = 0;     // when the monitor saw the newest activation, or counted a miss
    uint32_t activations = 0;  // as the monitor saw them, modulo 2^32
    uint32_t missed = 0;       // windows that passed without an activation
    bool is_silent = false;
};

// One row of the generated table; constant.
struct Watched {
    const char* name;
    uint32_t task;  // index
    const TaskCounters* counters;
    WatchState* state;
    uint32_t window_us;
    const ModeGate* gate;  // of a node that runs in some modes only, else null
};

// Looks for a life sign; true if a window has just passed without one. Never true too early: the
// monitor sees an activation after it happened. Context: the monitor.
inline bool misses_life_sign(const Watched& row, uint64_t now_us) {
    WatchState& state = *row.state;
    const uint32_t activations = __atomic_load_n(&row.counters->activations, __ATOMIC_RELAXED);
    const bool is_off = row.gate != nullptr && row.gate->epoch.load() % 2 == 0;
    if (activations != state.activations || is_off) {
        state.activations = activations;
        state.since_us = now_us;
        state.is_silent = false;
        return false;
    }
    if (now_us - state.since_us <= row.window_us) return false;
    state.since_us = now_us;
    state.missed += 1;
    state.is_silent = true;
    return true;
}

// Tells the log of publications that were refused since it was told last. Context: the monitor.
inline void tell_refused_publications(uint64_t now_us) {
    static uint32_t told = 0;
    const uint32_t count = refused_publications.count.load(std::memory_order_acquire);
    if (count == told) return;
    told = count;
    const char* output = refused_publications.newest.load(std::memory_order_relaxed);
    event_log.add({now_us, "published more often than its burst allows: ", output});
}

// A turn of the monitor: true if every watched task shows life.
inline bool all_show_life(const Watched* rows, unsigned count, uint64_t now_us) {
    tell_refused_publications(now_us);
    bool all = true;
    for (unsigned i = 0; i < count; ++i) {
        if (misses_life_sign(rows[i], now_us)) {
            event_log.add({now_us, "no life sign of ", rows[i].name});
        }
        all = all && !rows[i].state->is_silent;
    }
    return all;
}

// Windows that passed without an activation, of all tasks.
inline uint64_t missed_life_signs(const Watched* rows, unsigned count) {
    uint64_t missed = 0;
    for (unsigned i = 0; i < count; ++i) missed += rows[i].state->missed;
    return missed;
}

}  // namespace stator
