// Runs a graph in virtual time: by default an activation takes no time, everything due at one
// instant is pended before anything runs, and a flight is a function of graph, parameters and seed.
#pragma once

#include <cstdint>
#include <span>

#include "stator/task.hpp"
#include "stator/watch.hpp"

namespace stator {

// One row of the generated task table, most urgent first.
struct Task {
    const char* name;
    void (*run)();
    TaskCounters* counters;
    unsigned level_begin;  // index of the first task of its level
};

// The generated graph as the executor needs it.
struct Program {
    const Task* tasks;
    unsigned task_count;
    const Timer* timers;
    unsigned timer_count;
    uint64_t* pending;
    unsigned words;
    const unsigned* level_begin;
    const Watched* watched;
    unsigned watched_count;
    void (*start)();  // constructs drivers' connections and publishes the parameters
};
extern const Program program;

// An event of a device that can activate a node; the board raises it.
class Line {
  public:
    void connect(LineState& state, const Pend& pend, uint32_t min_interarrival_us) {
        state_ = &state;
        pend_ = pend;
        min_interarrival_us_ = min_interarrival_us;
    }
    // Notes the line with the clock and pends its task; nothing runs before `dispatch`.
    void raise();

  private:
    LineState* state_ = nullptr;
    Pend pend_{};
    uint32_t min_interarrival_us_ = 0;
};

// What the board adds to virtual time: its next event, and making all that is due happen.
namespace board {
inline constexpr uint64_t kNever = UINT64_MAX;
uint64_t next_event_us();
void advance(uint64_t now_us);
}  // namespace board

// Durations of activations in a run, other than zero (`--times random`): each preemption point
// takes 0 to `most_us` microseconds, drawn from `seed`.
struct RandomTimes {
    uint64_t seed;
    uint32_t most_us;
};
void use_random_times(const RandomTimes& times);

// Activations take the budgets of their tasks, in the order of `program.tasks`, and a task that is
// due meanwhile preempts them at that very time (`--times budget`). The time passes in equal parts
// at as many preemption points as the activation before had, and what is left at its end.
void use_budgets(std::span<const uint32_t> budgets_us);

// The task's activations are left out from then until then, and its outputs keep what they have.
// `is_watched`: that counts as missed life signs. False: unknown task.
[[nodiscard]] bool silence(const char* task, uint64_t from_us, uint64_t until_us,
                           bool is_watched = true);

// Connects the graph to the board and publishes the parameters, at time 0.
void start();
// Runs everything due up to and including `end_us`, or until `stop()`.
void run_until(uint64_t end_us);
void stop();

}  // namespace stator
