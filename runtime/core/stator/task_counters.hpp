// What is counted of each task. The emulated chip's host reads it in the firmware's memory.
#pragma once

#include <cstdint>

namespace stator {

// Counts for `top`, the report and the proof's watch; modulo 2^32.
struct TaskCounters {
    uint32_t activations = 0;   // the monitor reads it at any time
    uint32_t lost_samples = 0;  // missed by inputs, refused to outputs
    // Where the executor measures. In ticks of its clock, without what interrupted the task:
    uint32_t ticks = 0;  // the sum, modulo 2^32
    uint32_t last_ticks = 0;
    uint32_t most_ticks = 0;
    uint32_t latest_us = 0;  // longest from `now` to the end
};

}  // namespace stator
