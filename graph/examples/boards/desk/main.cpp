// Runs a graph for one second of virtual time and prints how often each task ran.
#include <cstdint>
#include <cstdio>

#include "stator/virtual.hpp"

namespace stator::board {

uint64_t next_event_us() {
    return kNever;
}

void advance(uint64_t /*now_us*/) {}

}  // namespace stator::board

int main() {
    stator::start();
    stator::run_until(1'000'000);
    for (unsigned i = 0; i < stator::program.task_count; ++i) {
        const stator::Task& task = stator::program.tasks[i];
        std::printf("%s: %llu\n", task.name,
                    static_cast<unsigned long long>(task.counters->activations));
    }
}
