// Runs a graph on bare metal: what the generated vector table, the board and the start-up code know
// of each other.
#pragma once

#include <cstdint>

#include "stator/fault_record.hpp"
#include "stator/link.hpp"
#include "stator/task.hpp"
#include "stator/watch.hpp"

namespace stator {

// One row of the generated task table, most urgent first.
struct Task {
    const char* name;
    const TaskCounters* counters;
};

// A vector that the graph uses.
struct Interrupt {
    uint8_t vector;
    uint8_t level;
};

// The generated graph as the executor needs it.
struct Program {
    const Task* tasks;
    unsigned task_count;
    const Timer* timers;
    unsigned timer_count;
    unsigned timer_level;  // highest level of a periodic task; 1 if there is none
    const Interrupt* interrupts;
    unsigned interrupt_count;
    const Watched* watched;
    unsigned watched_count;
    const Topic* const* topics;
    unsigned topic_count;
    uint32_t core_clock_hz;
    const char* board;       // name
    const char* graph;       // name
    const char* graph_hash;  // of what behaves, in hexadecimal
    void (*start)();         // publishes the parameters
};
extern const Program program;

// Handlers of the generated vector table that are not the graph's own.
extern "C" {
[[noreturn]] void stator_reset();
void stator_fault();  // naked; every vector that nobody uses ends here, too
void stator_release();
// Naked: for the timer at hardware priority 0 that a board may have as its watchdog, or as the
// warning before it. Leaves a record and resets if the watchdog was not kicked.
void stator_watchdog_timer();
}

// Protects the null page, the flash, the stack's end, and memory that holds no code.
void guard_memory();

// Looks for life signs, and kicks the watchdog if there are all. Context: thread mode, below every
// task.
void monitor();
// Answers what came on the link. Context: the monitor.
void serve_link();

// Set by a board that has a link, in `prepare`.
extern const Transport* link_transport;

// Microseconds since boot, from the board's 32-bit timer. Any context; constant time; needs to be
// called from anywhere at least every 2^31 us, which SysTick sees to.
uint64_t clock_us();

// How often SysTick has released what was due, modulo 2^32.
extern Shared<uint32_t> release_count;

// At the entry of a line's vector: notes it with the clock. False: refused, as too early.
bool note_line(LineState& line, uint32_t min_interarrival_us);

// True while the vector is pending or active, so that its task may be reading its device.
inline bool is_busy(const Pend& pend) {
    const uint32_t bits = nvic::set_pending(pend.word).read() | nvic::active(pend.word).read();
    return (bits & pend.mask) != 0;
}

// Makes the motors safe and resets; nothing is told of it by the next start. For a vehicle that is
// disarmed. Any task.
[[noreturn]] void restart();

// What a board supplies.
namespace board {
void prepare();  // before the graph: clocks, the 32-bit timer, devices
void start();    // after all vectors are enabled: lines may be raised from here on
uint32_t timer_us();
// For how long a task runs; modulo 2^32. Inlined where the image is optimised at once.
uint32_t ticks();
extern const TickSource kTickSource;  // what they are
// Puts the motors into their defined state. Any context, also that of a fault, and before
// `prepare`: short, bounded, without the graph.
void make_safe();
// Tells that the run before failed. Before `prepare`, as that may be what fails.
void report(const FaultRecord& record);
// Only `monitor` calls it, and only while every watched task shows life.
void kick_watchdog();
// Of a board that uses `stator_watchdog_timer`: whether it was, since the last call.
bool watchdog_was_kicked();
}  // namespace board

}  // namespace stator
