// Runs a graph on bare metal: what the generated vector table, the board and the start-up code know
// of each other.
#pragma once

#include <cstdint>

#include "stator/task.hpp"

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
    uint32_t core_clock_hz;
    void (*start)();  // publishes the parameters
};
extern const Program program;

// Handlers of the generated vector table that are not the graph's own.
extern "C" {
[[noreturn]] void stator_reset();
void stator_fault();  // naked; every vector that nobody uses ends here, too
void stator_release();
}

// Microseconds since boot, from the board's 32-bit timer. Any context; constant time; needs to be
// called from anywhere at least every 2^31 us, which SysTick sees to.
uint64_t clock_us();

// At the entry of a line's vector: notes it with the clock. False: refused, as too early.
bool note_line(LineState& line, uint32_t min_interarrival_us);

// True while the vector is pending or active, so that its task may be reading its device.
inline bool is_busy(const Pend& pend) {
    const uint32_t bits = nvic::set_pending(pend.word).read() | nvic::active(pend.word).read();
    return (bits & pend.mask) != 0;
}

// What a fault leaves behind. `program_counter` is 0 if the stack it lay on cannot be read.
struct Fault {
    uint32_t exception;  // number: 3 HardFault ... 6 UsageFault; from 16 on, a vector of nobody
    uint32_t status;     // CFSR
    uint32_t hard_status;
    uint32_t memory_address;
    uint32_t bus_address;
    uint32_t program_counter;
};

// What a board supplies.
namespace board {
void prepare();  // before the graph: clocks, the 32-bit timer, devices
void start();    // after all vectors are enabled: lines may be raised from here on
uint32_t timer_us();
[[noreturn]] void halt(const char* what);
[[noreturn]] void halt(const Fault& fault);
}  // namespace board

}  // namespace stator
