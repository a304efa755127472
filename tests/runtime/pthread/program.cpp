// The smallest program for the executor of threads.
#include "program.hpp"

namespace stator {

namespace testing {

std::array<std::function<void()>, kTasks> jobs;
Line line;
LineState line_state;
uint32_t least_between_us = 0;
TimerState timer_state;

bool wait_for(const std::function<bool()>& condition) {
    const uint64_t end_us = clock_us() + kForever_us;
    for (; !condition(); sleep_until_us(clock_us() + 500)) {
        if (clock_us() > end_us) return false;
    }
    return true;
}

namespace {

template <unsigned index>
void run() {
    if (jobs[index]) jobs[index]();
}

TaskCounters counters[kTasks];
Line* const lines[] = {&line};
constexpr Task kTaskRows[] = {
    {"high", run<0>, &counters[0], nullptr, 0},     {"high_peer", run<1>, &counters[1], nullptr, 0},
    {"driver", run<2>, &counters[2], lines, 1},     {"middle", run<3>, &counters[3], nullptr, 0},
    {"periodic", run<4>, &counters[4], nullptr, 0}, {"low", run<5>, &counters[5], nullptr, 0},
};
constexpr Timer kTimers[] = {{&timer_state, 1000, 0, kPends[4]}};
constexpr Level kLevels[] = {{9, 0, 2, 0, 0}, {5, 2, 2, 0, 0}, {1, 4, 2, 0, 1}};

}  // namespace

}  // namespace testing

extern const Program program;
constinit const Program program{
    .tasks = testing::kTaskRows,
    .task_count = testing::kTasks,
    .timers = testing::kTimers,
    .timer_count = 1,
    .levels = testing::kLevels,
    .level_count = 3,
    .watched = nullptr,
    .watched_count = 0,
    .start =
        [] {
            testing::line.connect(testing::line_state, testing::kPends[2],
                                  testing::least_between_us);
        },
};

}  // namespace stator
