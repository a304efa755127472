// What a topic costs beside plain memory: publishing 64 bytes that wake nobody against the same
// stores, and reading the newest sample against a plain load of one of its fields.
#include <benchmark/benchmark.h>

#include "stator/port.hpp"
#include "stator/testing.hpp"
#include "stator/virtual.hpp"

namespace {

struct Sample {
    uint64_t timestamp{};
    uint64_t value[7]{};
};
static_assert(sizeof(Sample) == 64);

// Wide enough that samples are built with plain stores into memory the compiler cannot see through.
struct Topic64 {
    Topic64() { benchmark::DoNotOptimize(topic); }
    stator::TopicState state{stator::Shared<uint32_t>(stator::all_slots(3)), {}, {}};
    Sample samples[3]{};
    stator::Shared<uint32_t> number[3]{};
    stator::Topic topic{.state = &state,
                        .samples = samples,
                        .number = number,
                        .ring = nullptr,
                        .subscribers = nullptr,
                        .thinned = nullptr,
                        .in_section = nullptr,
                        .sample_bytes = sizeof(Sample),
                        .subscriber_count = 0,
                        .thinned_count = 0,
                        .slots = 3,
                        .depth = 1,
                        .ceiling = 0};
};

void plain_stores(benchmark::State& run) {
    Sample sample;
    Sample* target = &sample;
    uint64_t x = 1;
    for (auto _ : run) {
        benchmark::DoNotOptimize(target);
        benchmark::DoNotOptimize(x);
        *target = Sample{.timestamp = x, .value = {x, x, x, x, x, x, x}};
        benchmark::ClobberMemory();
    }
}
BENCHMARK(plain_stores);

void publish(benchmark::State& run) {
    Topic64 memory;
    stator::Output<Sample> output;
    uint64_t x = 1;
    for (auto _ : run) {
        output.connect(memory.topic, 1, true);
        benchmark::DoNotOptimize(x);
        output.publish([&] { return Sample{.timestamp = x, .value = {x, x, x, x, x, x, x}}; });
        benchmark::ClobberMemory();
    }
}
BENCHMARK(publish);

void plain_load(benchmark::State& run) {
    Sample sample{.timestamp = 1, .value = {1}};
    const Sample* source = &sample;
    for (auto _ : run) {
        benchmark::DoNotOptimize(source);
        uint64_t value = source->value[3];
        benchmark::DoNotOptimize(value);
    }
}
BENCHMARK(plain_load);

void read_latest(benchmark::State& run) {
    Topic64 memory;
    stator::Output<Sample> output;
    output.connect(memory.topic, 1, true);
    output.publish([&] { return Sample{.timestamp = 1, .value = {1}}; });
    uint32_t cursor = 0;
    for (auto _ : run) {
        stator::Input<Sample> input;
        input.take_latest(memory.topic, cursor, 2);
        uint64_t value = input->value[3];
        benchmark::DoNotOptimize(value);
    }
}
BENCHMARK(read_latest);

}  // namespace

BENCHMARK_MAIN();
