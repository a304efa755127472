// The virtual-time executor: one loop over instants, nested dispatch inside publications.
#include "stator/virtual.hpp"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <vector>

#include "stator/events.hpp"
#include "stator/host.hpp"
#include "stator/running.hpp"

namespace stator {

Executor executor;
LogEvents event_log;

namespace {

bool stopped = false;
uint64_t run_end_us = 0;
RandomTimes random_times{};
uint64_t random_state = 0;

// An activation that takes its budget.
struct TimedJob {
    unsigned task;
    uint32_t left_us;
    unsigned points = 0;  // that it has passed
    TimedJob* outer = nullptr;
};
TimedJob* timed_job = nullptr;        // the innermost
std::vector<uint32_t> budgets;        // by task, us; empty: activations do not take their budgets
std::vector<unsigned> points_before;  // by task: of the activation before

// A task that is not run from then until then.
struct Silence {
    unsigned task;
    uint64_t from_us;
    uint64_t until_us;
    bool is_watched;

    bool acts() const { return executor.now_us >= from_us && executor.now_us < until_us; }
};
std::vector<Silence> silences;

bool is_silent(unsigned task) {
    return std::any_of(silences.begin(), silences.end(),
                       [task](const Silence& s) { return s.task == task && s.acts(); });
}

// Nothing watches a task of a machine that has stopped.
void excuse_silent() {
    for (unsigned i = 0; i < program.watched_count; ++i) {
        const Watched& row = program.watched[i];
        for (const Silence& silence : silences) {
            const bool is_excused = silence.task == row.task && !silence.is_watched;
            if (is_excused && silence.acts()) row.state->since_us = executor.now_us;
        }
    }
}

// SplitMix64 (Steele, Lea, Flood 2014): one step of its counter, mixed.
uint64_t next_random() {
    random_state += 0x9E3779B97F4A7C15U;
    uint64_t z = random_state;
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9U;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBU;
    return z ^ (z >> 31);
}

uint64_t next_instant_us() {
    uint64_t next = board::next_event_us();
    for (unsigned i = 0; i < program.timer_count; ++i) {
        const uint64_t release = next_release_us(program.timers[i]);
        if (release < next) next = release;
    }
    return next;
}

// Pends everything due by now: first the board's lines, then the timers.
void pend_due() {
    board::advance(executor.now_us);
    for (unsigned i = 0; i < program.timer_count; ++i) {
        const Timer& timer = program.timers[i];
        while (next_release_us(timer) <= executor.now_us) {
            release(timer);
        }
    }
}

// Lets the job run for so long; others come in between when they are due, and time passes for them.
void spend(TimedJob& job, uint32_t time_us) {
    while (time_us != 0 && executor.now_us < run_end_us) {
        const uint64_t instant = std::max(next_instant_us(), executor.now_us);
        const auto step_us =
            static_cast<uint32_t>(std::min<uint64_t>(time_us, instant - executor.now_us));
        executor.now_us += step_us;
        time_us -= step_us;
        job.left_us -= step_us;
        if (executor.now_us < instant) return;
        executor.preemption_armed = false;  // what pends has no preemption points of its own
        pend_due();
        executor.preemption_armed = true;
        preempt();
    }
}

void run_timed(unsigned index) {
    const Task& task = program.tasks[index];
    TimedJob job{.task = index, .left_us = budgets[index], .outer = timed_job};
    timed_job = &job;
    const uint64_t before = task.counters->activations;
    task.run();
    // A task that finds nothing to do takes no time.
    if (task.counters->activations != before) {
        spend(job, job.left_us);
        points_before[index] = job.points;
    }
    timed_job = job.outer;
}

}  // namespace

void fail(const char* what) {
    std::fprintf(stderr, "stator: %s at %llu us\n", what,
                 static_cast<unsigned long long>(executor.now_us));
    std::abort();
}

void dispatch() {
    const unsigned outer = executor.limit;
    for (unsigned index = first_pending(); index < outer; index = first_pending()) {
        executor.pending[index / 64] &= ~(uint64_t{1} << (index % 64));
        if (!silences.empty() && is_silent(index)) continue;
        const Task& task = program.tasks[index];
        executor.limit = task.level_begin;
        const char* const outer_node = running_node;
        running_node = task.name;
        host::activations = host::activations + 1;
        if (budgets.empty()) {
            task.run();
        } else {
            run_timed(index);
        }
        running_node = outer_node;
        executor.limit = outer;
    }
}

bool silence(const char* task, uint64_t from_us, uint64_t until_us, bool is_watched) {
    for (unsigned i = 0; i < program.task_count; ++i) {
        if (std::strcmp(program.tasks[i].name, task) != 0) continue;
        silences.push_back({i, from_us, until_us, is_watched});
        return true;
    }
    return false;
}

void use_random_times(const RandomTimes& times) {
    require(kHasPreemptionPoints, "this build has no preemption points");
    random_times = times;
    random_state = times.seed;
    executor.preemption_armed = true;
}

void use_budgets(std::span<const uint32_t> budgets_us) {
    require(kHasPreemptionPoints, "this build has no preemption points");
    require(budgets_us.size() == program.task_count, "a budget for each task is needed");
    budgets.assign(budgets_us.begin(), budgets_us.end());
    points_before.assign(budgets.size(), 0);
    executor.preemption_armed = true;
}

void pass_preemption_point() {
    if (!budgets.empty()) {
        if (timed_job == nullptr) return;
        const unsigned expected = points_before[timed_job->task];
        const unsigned passed = timed_job->points++;
        if (passed < expected) spend(*timed_job, timed_job->left_us / (expected - passed));
        return;
    }
    if (executor.now_us >= run_end_us) return;  // also a machine that is overloaded comes to an end
    executor.preemption_armed = false;          // what pends has no preemption points of its own
    executor.now_us += next_random() % (random_times.most_us + 1);
    if (next_instant_us() <= executor.now_us) pend_due();
    executor.preemption_armed = true;
    preempt();
}

void Line::raise() {
    if (state_ == nullptr) return;
    if (!accept_line(*state_, executor.now_us, min_interarrival_us_)) return;
    state_->fires.store(state_->fires.load() + 1);
    set_pending(pend_);
}

void start() {
    executor.pending = program.pending;
    executor.words = program.words;
    executor.level_begin = program.level_begin;
    executor.limit = 0;  // nothing runs before the first instant
    program.start();
    executor.limit = program.task_count;
}

void run_until(uint64_t end_us) {
    stopped = false;
    run_end_us = end_us;
    while (!stopped) {
        const uint64_t instant = next_instant_us();
        if (instant > end_us) break;
        if (instant > executor.now_us) executor.now_us = instant;
        const bool armed = executor.preemption_armed;
        executor.preemption_armed = false;
        pend_due();
        executor.preemption_armed = armed;
        preempt();
        if (!silences.empty()) excuse_silent();
        all_show_life(program.watched, program.watched_count, executor.now_us);
    }
}

void stop() {
    stopped = true;
}

}  // namespace stator
