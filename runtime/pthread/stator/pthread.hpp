// Runs a graph as threads, in real time: one for each level, and one that waits for devices.
#pragma once

#include <pthread.h>

#include <cstddef>
#include <cstdint>
#include <vector>

#include "stator/line.hpp"
#include "stator/task.hpp"
#include "stator/watch.hpp"

namespace stator {

// One row of the generated task table, most urgent first.
struct Task {
    const char* name;
    void (*run)();
    TaskCounters* counters;
    Line* const* lines;
    unsigned line_count;
};

// One row of the generated level table, most urgent first. The bits of its word are its tasks, in
// planned order; its timers stand together, too.
struct Level {
    unsigned priority;  // 1 to 15
    unsigned first_task;
    unsigned task_count;
    unsigned first_timer;
    unsigned timer_count;
};

// The generated graph as the executor needs it.
struct Program {
    const Task* tasks;
    unsigned task_count;
    const Timer* timers;
    unsigned timer_count;
    const Level* levels;
    unsigned level_count;
    const Watched* watched;
    unsigned watched_count;
    void (*start)();  // connects the lines and publishes the parameters
    // What the link tells:
    const Topic* const* topics = nullptr;  // in the order of the plan
    unsigned topic_count = 0;
    const char* board = "";                       // name
    const char* graph = "";                       // name
    const char* graph_hash = "0000000000000000";  // of what behaves, in hexadecimal
};
extern const Program program;

// What the machine should grant.
struct Settings {
    uint64_t cpus = 0;      // bit i: the levels may run on processor i; 0: on any
    bool real_time = true;  // SCHED_FIFO and locked memory
    double speed = 1.0;     // of the graph's clock against the machine's; not above 1
};

// Something that the machine did not grant, for people.
struct Refusal {
    const char* what;
    const char* why;
    const char* cost;
    const char* remedy;
};

// What a level did, once `finish` has returned; zeros of one that is left.
struct LevelFacts {
    uint64_t wakes = 0;
    uint64_t cpu_ns = 0;
    uint64_t worst_release_ns = 0;  // from a release's nominal time to its pending
};

// Microseconds since `start`, of CLOCK_MONOTONIC times the speed. Any thread.
uint64_t clock_us();
// The same clock at its full resolution.
uint64_t clock_ns();

// CPU time of the calling thread.
uint64_t thread_cpu_ns();

// Sleeps until the clock says so.
void sleep_until_us(uint64_t time_us);

// A thread of the board's own, above all levels, as an interrupt would be. False if there is none
// for it.
[[nodiscard]] bool make_device_thread(pthread_t& thread, const char* name, void (*run)(void*),
                                      void* object);

// Starts the graph: all levels exist before the first task runs. SIGINT, SIGTERM and (unless it
// is ignored) SIGHUP end `wait` from here on. False, after one line on the standard error output,
// if the machine has no threads for it; then nothing runs. Once a process.
[[nodiscard]] bool start(const Settings& settings = {});
const std::vector<Refusal>& refusals();
bool is_real_time();  // the levels have SCHED_FIFO

// Before `start`: makes a Unix socket at `path`, where `wait_until` answers what docs/link.md
// lists, until `finish` removes it. One that nobody serves any more is replaced. False, after one
// line on the standard error output, if there can be none.
[[nodiscard]] bool offer_link(const char* path);

enum class Ending { kTime, kStopped, kSignal };
// Waits until time `end_us`, `stop()`, or a signal; meanwhile, looks for life signs.
Ending wait_until(uint64_t end_us);
int ending_signal();  // its number; 0: none
// Any thread, any task.
void stop();

// Waits until every level sleeps with nothing pending, at most so long. Lines and timers go on.
bool wait_until_idle(uint64_t longest_us);

// Ends the graph in order: no more lines, no more releases; what is pending runs to its end, then
// the levels end. True if everything came to its end within a second of the clock; what was not
// begun until then is left out, and no thread is left, but for levels with a task that does not end
// in the second after: they are left running, `unended_task` says which, and these signals end
// the process again. End it with `_exit` then, as nothing that the task uses may be destroyed.
bool finish();
// What a level that is left is in; null: the level has ended.
const Task* unended_task(unsigned level);
LevelFacts facts_of_level(unsigned level);

}  // namespace stator
