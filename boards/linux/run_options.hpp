// What a run in real time is asked for beyond what every flight is.
#pragma once

#include "stator/pthread.hpp"

namespace stator::board {

struct RunOptions {
    const char* can_interface = nullptr;  // none: no bus
    // Where motor controllers and a satellite receiver are simulated; none: nowhere.
    const char* can_parts = nullptr;
    const char* nonvolatile = nullptr;  // file of the records that outlive a run; none: no memory
    const char* link = nullptr;         // where `top` and others find this run; none: nowhere
    Settings settings;
};

// Takes --can INTERFACE, --can-parts INTERFACE, --nonvolatile FILE, --link SOCKET, --speed FACTOR
// and --cpus MASK (hexadecimal, bit i: processor i) out of the arguments. False after one line on
// the standard error output that says what is wrong.
[[nodiscard]] bool take_run_options(int& count, char** arguments, RunOptions& options);

}  // namespace stator::board
