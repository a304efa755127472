// What timing an activation costs on threads, beside the reads of clocks that it could be made of.
#include <benchmark/benchmark.h>

#include "stator/activation.hpp"
#include "stator/pthread.hpp"

namespace stator {

extern const Program program;
constinit const Program program{};

namespace {

void activation(benchmark::State& run) {
    TaskCounters counters;
    for (auto _ : run) {
        Activation activation(0, counters);
        benchmark::ClobberMemory();
        activation.finish();
    }
}
BENCHMARK(activation);

void activation_with_response(benchmark::State& run) {
    TaskCounters counters;
    for (auto _ : run) {
        Activation activation(0, counters);
        benchmark::ClobberMemory();
        activation.finish(1);
    }
}
BENCHMARK(activation_with_response);

void cpu_clock(benchmark::State& run) {
    for (auto _ : run) benchmark::DoNotOptimize(thread_cpu_ns());
}
BENCHMARK(cpu_clock);

void monotonic_clock(benchmark::State& run) {
    for (auto _ : run) benchmark::DoNotOptimize(clock_ns());
}
BENCHMARK(monotonic_clock);

}  // namespace
}  // namespace stator

BENCHMARK_MAIN();
