// What single calls cost on the ring between threads, beside plain memory.
#include <benchmark/benchmark.h>

#include "measured.hpp"
#include "stator/port.hpp"

namespace stator {

// No thread runs here.
PendingWord pending_words[kMaxLevels];
constinit thread_local unsigned current_level = 0;
void wake_level(uint32_t) {}
void fail(const char*) {
    __builtin_trap();
}

namespace {

using measured::Sample;

struct Topic64 {
    Topic64() { benchmark::DoNotOptimize(topic); }
    Sample samples[3]{};
    RingEntry ring[1];
    SlotState users[3];
    TopicState state;
    Pend subscribers[1]{{0, 1}};
    Topic topic{.state = &state,
                .samples = samples,
                .ring = ring,
                .users = users,
                .mutex = nullptr,
                .subscribers = subscribers,
                .thinned = nullptr,
                .sample_bytes = sizeof(Sample),
                .subscriber_count = 1,
                .thinned_count = 0,
                .slots = 3,
                .depth = 1};
};

void publish_once(const Topic64& memory, uint64_t x) {
    Output<Sample> output;
    output.connect(memory.topic, x, true);
    output.publish([&] { return Sample{.sent_ns = x, .value = {x, x, x, x, x, x}}; });
}

void plain_stores(benchmark::State& run) {
    Sample sample;
    Sample* target = &sample;
    uint64_t x = 1;
    for (auto _ : run) {
        benchmark::DoNotOptimize(target);
        benchmark::DoNotOptimize(x);
        *target = Sample{.timestamp = x, .sent_ns = x, .value = {x, x, x, x, x, x}};
        benchmark::ClobberMemory();
    }
}
BENCHMARK(plain_stores);

// The subscriber's level runs, so that nobody is woken.
void publish_awake(benchmark::State& run) {
    Topic64 memory;
    pending_words[0].bits.store(kAwakeBit);
    uint64_t x = 1;
    for (auto _ : run) {
        benchmark::DoNotOptimize(x);
        publish_once(memory, x);
        benchmark::ClobberMemory();
    }
}
BENCHMARK(publish_awake);

void plain_load(benchmark::State& run) {
    Sample sample{.sent_ns = 1};
    const Sample* source = &sample;
    for (auto _ : run) {
        benchmark::DoNotOptimize(source);
        uint64_t value = source->value[3];
        benchmark::DoNotOptimize(value);
    }
}
BENCHMARK(plain_load);

// The newest sample, which is the one that was read before.
void read_latest(benchmark::State& run) {
    Topic64 memory;
    publish_once(memory, 1);
    uint32_t seen = 0;
    for (auto _ : run) {
        Pin pin;
        benchmark::DoNotOptimize(memory);
        take_latest(memory.topic, seen, pin);
        uint64_t value = static_cast<const Sample*>(memory.topic.samples)[pin.slot].value[3];
        benchmark::DoNotOptimize(value);
        seen = pin.number;
        release(memory.topic, pin);
    }
}
BENCHMARK(read_latest);

// A publication and the read of what it published: less `publish_awake`, what a new sample costs.
void read_new(benchmark::State& run) {
    Topic64 memory;
    pending_words[0].bits.store(kAwakeBit);
    uint32_t seen = 0;
    uint64_t x = 1;
    for (auto _ : run) {
        benchmark::DoNotOptimize(x);
        publish_once(memory, x);
        benchmark::ClobberMemory();
        Pin pin;
        take_latest(memory.topic, seen, pin);
        uint64_t value = static_cast<const Sample*>(memory.topic.samples)[pin.slot].value[3];
        benchmark::DoNotOptimize(value);
        seen = pin.number;
        release(memory.topic, pin);
    }
}
BENCHMARK(read_new);

void poll_nothing_new(benchmark::State& run) {
    Topic64 memory;
    publish_once(memory, 1);
    for (auto _ : run) {
        benchmark::DoNotOptimize(memory);
        bool is_new = has_unread(memory.topic, 1);
        benchmark::DoNotOptimize(is_new);
    }
}
BENCHMARK(poll_nothing_new);

}  // namespace

}  // namespace stator

BENCHMARK_MAIN();
