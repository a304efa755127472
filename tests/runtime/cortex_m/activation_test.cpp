// What a task is told of its own time, wherever more urgent tasks come in.
#include "stator/activation.hpp"

#include <gtest/gtest.h>

#include <array>
#include <optional>

namespace stator {

ActivationRing activation_ring;

namespace {

constexpr unsigned kJobs = 3;
constexpr unsigned kWork = 3;        // points inside a step
constexpr unsigned kMaxPoints = 16;  // of an activation without repetitions
constexpr unsigned kNever = kMaxPoints;

// One activation of each level, which the next level interrupts at one or two points. Time
// passes at points only.
struct Schedule {
    std::array<std::array<unsigned, 2>, kJobs> interrupted_at;
    std::array<unsigned, kJobs> length;  // what a point of the step takes
};

struct Job {
    unsigned level;
    unsigned point = 0;
    uint32_t inside = 0;  // ticks of the jobs that came in
    uint32_t tail = 0;    // of these, of those that came while it finished
    bool is_finishing = false;
};

const Schedule* schedule = nullptr;
Job* running = nullptr;
uint32_t clock = 0;

void run(unsigned level);

}  // namespace

namespace testing {
void pass_point() {
    if (running == nullptr) return;
    Job& job = *running;
    const unsigned point = job.point++;
    if (job.level + 1 < kJobs) {
        for (const unsigned at : schedule->interrupted_at[job.level]) {
            if (at != point) continue;
            const uint32_t begin = clock;
            run(job.level + 1);
            is_exclusive = false;
            job.inside += clock - begin;
            job.tail += job.is_finishing ? clock - begin : 0;
        }
    }
    ++clock;
}
}  // namespace testing

namespace board {
uint32_t ticks() {
    preemption_point();
    return clock;
}
}  // namespace board

namespace {

// Runs one activation, and checks what it is told.
void run(unsigned level) {
    Job job{level};
    Job* const outer = running;
    running = &job;
    const uint32_t begin = clock;
    TaskCounters counters;
    Activation activation(level, counters);
    for (unsigned i = 0; i < kWork; ++i) {
        preemption_point();
        clock += schedule->length[level];
    }
    job.is_finishing = true;
    activation.finish();
    running = outer;
    const uint32_t all = clock - begin;
    const uint32_t own = all - job.inside;
    const uint32_t told = counters.last_ticks;
    EXPECT_GE(told, kWork * schedule->length[level]) << "too little, or less than nothing";
    EXPECT_LE(told, all);
    // A job that comes between two lines of its own end, or of the end of one above, counts once.
    if (job.tail == 0 && (level + 1 == kJobs || job.inside == 0)) {
        EXPECT_LE(told, own);
    }
    ASSERT_FALSE(::testing::Test::HasFailure())
        << "level " << level << " is told " << told << " for " << own << "; interrupted at "
        << schedule->interrupted_at[0][0] << " and " << schedule->interrupted_at[0][1] << ", "
        << schedule->interrupted_at[1][0] << " and " << schedule->interrupted_at[1][1];
}

TEST(Activation, own_time_is_never_less_than_it_was_wherever_others_come_in) {
    unsigned count = 0;
    for (const unsigned longest : {1U, 20U, 1000U}) {
        for (unsigned a = 0; a <= kNever; ++a) {
            for (unsigned b = a; b <= kNever; ++b) {
                for (unsigned c = 0; c <= kNever; ++c) {
                    for (unsigned d = c; d <= kNever; ++d) {
                        const Schedule one{{{{a, b}, {c, d}, {kNever, kNever}}}, {1, 1, longest}};
                        schedule = &one;
                        clock = 0xFFFFFF00U;  // it wraps
                        run(0);
                        ++count;
                        if (HasFatalFailure()) return;
                    }
                }
            }
        }
    }
    EXPECT_EQ(count, 3U * 153 * 153);
}

}  // namespace
}  // namespace stator
