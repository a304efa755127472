// Runs the graph of this folder for so many seconds; the nodes abort at the first wrong sample, and
// the sanitizer at the first race. Then looks whether all is at rest, and whether all was counted.
#include <cstdio>
#include <cstdlib>

#include "../topic_rig.hpp"
#include "stator/pthread.hpp"
#include "tasks.hpp"
#include "topics.hpp"

namespace {

using namespace stator;

void expect_rest(const Topic& topic, const char* name) {
    const bool at_rest = stator::testing::is_at_rest(topic);
    std::printf("%-10s depth %2u, %2u slots: %u samples%s\n", name, topic.depth, topic.slots,
                topic.state->head.load(), at_rest ? "" : ": NOT AT REST");
    require(at_rest && topic.state->head.load() > 0, "stress: a topic is not at rest");
}

// Who reads every sample has seen or counted each.
void expect_all(const TaskCounters& counters, const Topic& topic) {
    require(counters.activations + counters.lost_samples == topic.state->head.load(),
            "stress: samples are missing");
}

void expect_releases() {
    for (unsigned i = 0; i < program.timer_count; ++i) {
        const TimerState& timer = *program.timers[i].state;
        require(timer.missed < timer.fires.load(), "stress: more missed than made");
    }
}

}  // namespace

int main(int count, char** arguments) {
    const double seconds = count == 2 ? std::atof(arguments[1]) : 1.0;
    if (!start()) return 2;
    wait_until(static_cast<uint64_t>(seconds * 1e6));
    require(finish(), "stress: the graph does not come to rest");
    expect_rest(topics::alone1, "alone1");
    expect_rest(topics::alone2, "alone2");
    expect_rest(topics::alone8, "alone8");
    expect_rest(topics::many1, "many1");
    expect_rest(topics::many2, "many2");
    expect_rest(topics::many4, "many4");
    expect_rest(topics::switched, "switched");
    expect_rest(topics::mode, "mode");
    expect_all(tasks::taker::state.counters, topics::many4);
    expect_all(tasks::always::state.counters, topics::switched);
    expect_releases();
    for (unsigned i = 0; i < program.task_count; ++i) {
        const TaskCounters& counters = *program.tasks[i].counters;
        std::printf("%-10s %9llu activations, %9llu samples lost\n", program.tasks[i].name,
                    static_cast<unsigned long long>(counters.activations),
                    static_cast<unsigned long long>(counters.lost_samples));
        require(counters.activations != 0, "stress: a node never ran");
    }
    return 0;
}
