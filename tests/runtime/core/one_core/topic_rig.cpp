// The smallest program for the virtual executor: three tasks on three levels, no timer, no device.
#include "topic_rig.hpp"

namespace stator {

namespace board {
uint64_t next_event_us() {
    return kNever;
}
void advance(uint64_t) {}
}  // namespace board

namespace testing {

std::array<std::function<void()>, 3> jobs;
uint64_t pending[1];

namespace {

template <unsigned index>
void run() {
    if (jobs[index]) jobs[index]();
}

TaskCounters counters[3];
constexpr Task kTasks[] = {
    {"high", run<0>, &counters[0], 0},
    {"middle", run<1>, &counters[1], 1},
    {"low", run<2>, &counters[2], 2},
};
// Levels 3, 2, 1; level 0 begins past the last task.
constexpr unsigned kLevelBegin[16] = {3, 2, 1};

}  // namespace

void begin() {
    jobs = {};
    pending[0] = 0;
    executor.now_us = 0;
    start();
}

}  // namespace testing

extern const Program program;
constinit const Program program{.tasks = testing::kTasks,
                                .task_count = 3,
                                .timers = nullptr,
                                .timer_count = 0,
                                .pending = testing::pending,
                                .words = 1,
                                .level_begin = testing::kLevelBegin,
                                .watched = nullptr,
                                .watched_count = 0,
                                .start = [] {}};

}  // namespace stator
