// What both sides of a comparison share: 64 bytes, their clock, a thread's priority, the result.
#pragma once

#include <pthread.h>

#include <cstdint>
#include <cstdio>
#include <ctime>
#include <vector>

namespace measured {

inline constexpr uint64_t kPeriod_ns = 1'000'000;

struct Sample {
    uint64_t timestamp{};
    uint64_t sent_ns{};
    uint64_t value[6]{};
};
static_assert(sizeof(Sample) == 64);

inline uint64_t now_ns() {
    timespec now{};
    clock_gettime(CLOCK_MONOTONIC, &now);
    return static_cast<uint64_t>(now.tv_sec) * 1'000'000'000 + static_cast<uint64_t>(now.tv_nsec);
}

inline void sleep_until(uint64_t time_ns) {
    timespec due{};
    due.tv_sec = static_cast<time_t>(time_ns / 1'000'000'000);
    due.tv_nsec = static_cast<long>(time_ns % 1'000'000'000);
    clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &due, nullptr);
}

// One row for each sample: how long the publishing call took, and how long the sample was on its
// way.
struct Row {
    uint32_t call_ns;
    uint32_t latency_ns;
};

inline void print(const Row& row) {
    std::printf("%u %u\n", row.call_ns, row.latency_ns);
}
inline void print(const std::vector<Row>& rows) {
    for (const Row& row : rows) print(row);
}

}  // namespace measured
