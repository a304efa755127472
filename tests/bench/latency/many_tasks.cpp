// 200 periodic tasks of 1 kHz on 8 levels: `many_tasks SECONDS [--spread] [--threads]`. --threads:
// each in a thread of its own. --spread: each due at a time of its own instead of all at once.
// Prints activations, releases that were missed, and CPU seconds.
#include <sys/prctl.h>
#include <sys/resource.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdlib>
#include <string_view>
#include <thread>
#include <utility>

#include "measured.hpp"
#include "stator/pthread.hpp"

namespace stator {

namespace {

constexpr unsigned kLevels = 8;
constexpr unsigned kTasksOfLevel = 25;
constexpr unsigned kTasks = kLevels * kTasksOfLevel;
constexpr uint32_t kPeriod_us = 1000;

TimerState timers[kTasks];
TaskCounters counters[kTasks];

template <unsigned index>
void run() {
    if (served_now(timers[index], kPeriod_us)) ++counters[index].activations;
}

template <unsigned... index>
constexpr std::array<Task, kTasks> task_rows(std::integer_sequence<unsigned, index...>) {
    return {Task{"task", run<index>, &counters[index], nullptr, 0}...};
}
template <unsigned... level>
constexpr std::array<Level, kLevels> level_rows(std::integer_sequence<unsigned, level...>) {
    return {Level{kLevels - level, level * kTasksOfLevel, kTasksOfLevel, level * kTasksOfLevel,
                  kTasksOfLevel}...};
}

constexpr auto kTaskRows = task_rows(std::make_integer_sequence<unsigned, kTasks>());
constexpr auto kLevelRows = level_rows(std::make_integer_sequence<unsigned, kLevels>());

Timer timer_rows[kTasks];  // `main` makes them

void make_timer_rows(bool is_spread) {
    for (unsigned i = 0; i < kTasks; ++i) {
        timer_rows[i] = {.state = &timers[i],
                         .period_us = kPeriod_us,
                         .offset_us = is_spread ? i * 37 % kPeriod_us : 0,
                         .pend = {i / kTasksOfLevel, 1U << i % kTasksOfLevel}};
    }
}

}  // namespace

extern const Program program;
constinit const Program program{.tasks = kTaskRows.data(),
                                .task_count = kTasks,
                                .timers = timer_rows,
                                .timer_count = kTasks,
                                .levels = kLevelRows.data(),
                                .level_count = kLevels,
                                .watched = nullptr,
                                .watched_count = 0,
                                .start = [] {}};

}  // namespace stator

namespace {

using stator::kTasks;

void run_levels(double seconds) {
    if (!stator::start()) std::exit(2);
    stator::wait_until(static_cast<uint64_t>(seconds * 1e6));
    stator::finish();
}

// The thread of one task: sleeps until its release, as people write it.
void run_thread(unsigned index, uint64_t start_ns, const std::atomic<bool>& ends) {
    prctl(PR_SET_TIMERSLACK, 1UL);
    const sched_param parameter{.sched_priority = 18 - static_cast<int>(index / 25)};
    pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameter);
    uint64_t due_ns = start_ns + uint64_t{stator::timer_rows[index].offset_us} * 1000;
    for (; !ends; due_ns += measured::kPeriod_ns) {
        measured::sleep_until(due_ns);
        ++stator::counters[index].activations;
        stator::timers[index].fires.store(stator::timers[index].fires.load() + 1);
    }
}

void run_threads(double seconds) {
    std::atomic<bool> ends{false};
    const uint64_t start_ns = measured::now_ns();
    std::vector<std::thread> threads;
    for (unsigned i = 0; i < kTasks; ++i)
        threads.emplace_back(run_thread, i, start_ns, std::cref(ends));
    std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
    ends = true;
    for (std::thread& thread : threads) thread.join();
}

double cpu_s() {
    rusage used{};
    getrusage(RUSAGE_SELF, &used);
    return static_cast<double>(used.ru_utime.tv_sec + used.ru_stime.tv_sec) +
           1e-6 * static_cast<double>(used.ru_utime.tv_usec + used.ru_stime.tv_usec);
}

}  // namespace

int main(int count, char** arguments) {
    if (count < 2) return 2;
    const double seconds = std::atof(arguments[1]);
    const std::vector<std::string_view> options(arguments + 2, arguments + count);
    const auto is_given = [&](std::string_view option) {
        return std::find(options.begin(), options.end(), option) != options.end();
    };
    stator::make_timer_rows(is_given("--spread"));
    const double before_s = cpu_s();
    if (is_given("--threads")) {
        run_threads(seconds);
    } else {
        run_levels(seconds);
    }
    unsigned long long activations = 0;
    unsigned long long missed = 0;
    unsigned long long releases = 0;
    for (unsigned i = 0; i < kTasks; ++i) {
        activations += stator::counters[i].activations;
        missed += stator::timers[i].missed;
        releases += stator::timers[i].fires.load();
    }
    std::printf("{\"activations\": %llu, \"missed\": %llu, \"releases\": %llu, \"cpu_s\": %0.6F}\n",
                activations, missed, releases, cpu_s() - before_s);
    return 0;
}
