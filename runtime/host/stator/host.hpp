// A program on this machine that runs a graph. Nodes may print, and may die.
#pragma once

#include <cstdint>
#include <cstdio>

namespace stator::host {

// Where facts for other programs go: the standard output that the program was started with.
inline std::FILE* facts = stdout;

// First of all, in the main thread. From here on, what is printed goes to the standard error
// output; what nodes print gets a head with time and node: `[  12.345678 s] lean: `. A node that
// crashes is named on the standard error output, in one line for codegen/stator/flight/crash.py,
// before the signal ends the program. `now_us`: the graph's clock, for any thread.
void begin(uint64_t (*now_us)());

// First of all in each other thread that runs nodes. A crash is reported on a stack of its own, as
// an endless recursion has used up the thread's.
void begin_thread();

// From here on, a step of the main thread that takes more than `limit_s` of processor time is
// reported as a crash that is called ENDLESS. Costs a signal each second.
void watch_steps(unsigned limit_s);

// Counts the activations of the main thread, for `watch_steps`.
inline volatile uint32_t activations = 0;

}  // namespace stator::host
