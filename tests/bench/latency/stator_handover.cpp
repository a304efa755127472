// From publication to reception between two levels, at 1 kHz: `stator_handover SAMPLES [--plain |
// --one-cpu]`. --plain: without SCHED_FIFO. --one-cpu: both levels on one processor.
#include <cstdlib>
#include <cstring>

#include "measured.hpp"
#include "stator/port.hpp"
#include "stator/pthread.hpp"

namespace stator {

namespace {

using measured::Sample;

constexpr Pend kSource{0, 1};
constexpr Pend kSink{1, 1};

TimerState timer_state;
TaskCounters counters[2];

Sample samples[3];
RingEntry ring[1];
SlotState users[3];
TopicState topic_state;
constexpr Pend subscribers[] = {kSink};
constexpr Topic topic{.state = &topic_state,
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

std::vector<measured::Row> rows;
std::size_t sent = 0;
std::size_t received = 0;

void source() {
    if (!served_now(timer_state, measured::kPeriod_ns / 1000) || sent == rows.size()) return;
    Output<Sample> output;
    output.connect(topic, sent, true);
    const uint64_t begin_ns = measured::now_ns();
    output.publish([&] { return Sample{.sent_ns = begin_ns, .value = {sent, 1, 2, 3, 4, 5}}; });
    rows[sent++].call_ns = static_cast<uint32_t>(measured::now_ns() - begin_ns);
}

void sink() {
    static uint32_t number = 0;
    Input<Sample> input;
    input.take_trigger(topic, number);
    if (!input) return;
    rows[input->value[0]].latency_ns = static_cast<uint32_t>(measured::now_ns() - input->sent_ns);
    if (++received == rows.size()) stop();
}

constexpr Task kTasks[] = {{"source", source, &counters[0], nullptr, 0},
                           {"sink", sink, &counters[1], nullptr, 0}};
constexpr Timer kTimers[] = {{&timer_state, measured::kPeriod_ns / 1000, 0, kSource}};
constexpr Level kLevels[] = {{9, 0, 1, 0, 1}, {5, 1, 1, 0, 0}};

}  // namespace

extern const Program program;
constinit const Program program{.tasks = kTasks,
                                .task_count = 2,
                                .timers = kTimers,
                                .timer_count = 1,
                                .levels = kLevels,
                                .level_count = 2,
                                .watched = nullptr,
                                .watched_count = 0,
                                .start = [] {}};

}  // namespace stator

int main(int count, char** arguments) {
    if (count < 2) return 2;
    stator::rows.resize(std::strtoul(arguments[1], nullptr, 10));
    const char* const option = count > 2 ? arguments[2] : "";
    const bool plain = std::strcmp(option, "--plain") == 0;
    const uint64_t cpus = std::strcmp(option, "--one-cpu") == 0 ? 1 : 0;
    if (!stator::start({.cpus = cpus, .real_time = !plain})) return 2;
    if (!plain && !stator::is_real_time()) std::fputs("not allowed: SCHED_FIFO\n", stderr);
    // A sample that is lost leaves the count short: then the time ends the run.
    stator::wait_until((stator::rows.size() * measured::kPeriod_ns / 1000) + 1'000'000);
    stator::finish();
    measured::print(stator::rows);
    return 0;
}
