// The smallest program for the executor of threads: tasks and lines that tests fill.
#pragma once

#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <functional>

#include "stator/port.hpp"
#include "stator/pthread.hpp"

namespace stator::testing {

// Levels 9, 5 and 1 with two tasks each; task i is jobs[i].
inline constexpr unsigned kTasks = 6;
extern std::array<std::function<void()>, kTasks> jobs;
inline constexpr std::array<Pend, kTasks> kPends{{{0, 1}, {0, 2}, {1, 1}, {1, 2}, {2, 1}, {2, 2}}};

// One line, of task 2; and a timer of task 4, each millisecond.
extern Line line;
extern LineState line_state;
extern uint32_t least_between_us;  // its min_interarrival, before `start`
extern TimerState timer_state;

// So long nothing may take: on a machine that is not broken, nothing does.
inline constexpr uint64_t kForever_us = 60'000'000;

// Waits until `condition()`; false after kForever_us.
bool wait_for(const std::function<bool()>& condition);

// Starts the graph without real-time priorities: a lock of the thread sanitizer spins, for ever if
// a less urgent thread was interrupted while it held the lock.
inline bool start_unhurried(double speed = 1.0) {
    return start({.real_time = false, .speed = speed});
}

// What the wrapper of task 2 does.
inline bool line_fired() {
    return served_now(line_state.fires, line_state.served);
}

}  // namespace stator::testing
