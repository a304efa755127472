// Runs random graphs in virtual time, with others preempting at every access. Aborts if a topic
// runs out of slots or a sample changes while it is held.
//   main SEED
#include <cstdio>
#include <cstdlib>

#include "idle.hpp"
#include "stator/virtual.hpp"

namespace stator::board {
uint64_t next_event_us() {
    return kNever;
}
void advance(uint64_t) {}
}  // namespace stator::board

int main(int, char** arguments) {
    using namespace stator;
    constexpr uint64_t kEnd_us = 20'000'000;
    constexpr uint32_t kMaxTime_us =
        3;  // of a point: the machine is busy for about half of the time
    start();
    use_random_times({std::strtoull(arguments[1], nullptr, 10), kMaxTime_us});
    run_until(kEnd_us);
    uint64_t activations = 0;
    for (unsigned i = 0; i < program.task_count; ++i) {
        activations += program.tasks[i].counters->activations;
    }
    check_idle();
    std::printf("{\"activations\": %llu, \"refused\": %u}\n",
                static_cast<unsigned long long>(activations), refused_publications.count.load());
}
