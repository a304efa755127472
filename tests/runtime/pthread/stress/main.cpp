// Runs the graph of this folder for so many seconds, and reads all of it as the link does; the
// nodes abort at the first wrong sample, and the sanitizer at the first race. Then looks whether
// all is at rest, and whether all was counted.
#include <array>
#include <cstdio>
#include <cstdlib>
#include <iterator>

#include "../topic_rig.hpp"
#include "apps/hammer/hammer.hpp"
#include "internal.hpp"
#include "stator/answers.hpp"
#include "stator/observe.hpp"
#include "stator/pthread.hpp"
#include "tasks.hpp"
#include "topics.hpp"

namespace {

using namespace stator;
using apps::hammer::is_whole;

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

constexpr const Topic* kBlocks[] = {&topics::alone1,  &topics::alone2, &topics::alone8,
                                    &topics::many1,   &topics::many2,  &topics::many4,
                                    &topics::switched};
constexpr unsigned kTopics = std::size(kBlocks);

// What the link does while the graph runs: it reads the newest of each topic, and all figures.
class Monitor {
  public:
    void look() {
        for (unsigned i = 0; i < kTopics; ++i) read(i);
        std::array<uint8_t, 1100> body;
        for (unsigned first = 0; first < program.task_count; first += kMaxTasksTold) {
            Writer out(body.data());
            put_tasks(out, program, clock_us(), first, figures_of_task);
        }
    }
    uint32_t samples() const { return samples_; }

  private:
    void read(unsigned topic) {
        Block block{};
        uint32_t number = 0;
        auto* const bytes = reinterpret_cast<uint8_t*>(&block);
        if (!copy_newest(*kBlocks[topic], bytes, sizeof block, number)) return;
        require(is_whole(block), "stress: the link reads a torn sample");
        require(number - numbers_[topic] < 1U << 31, "stress: the link goes backwards");
        require(number != numbers_[topic] || block.value == values_[topic],
                "stress: a sample has changed");
        samples_ += number != numbers_[topic] ? 1 : 0;
        numbers_[topic] = number;
        values_[topic] = block.value;
    }

    std::array<uint32_t, kTopics> numbers_{};
    std::array<uint64_t, kTopics> values_{};
    uint32_t samples_ = 0;
};

}  // namespace

int main(int count, char** arguments) {
    const double seconds = count == 2 ? std::atof(arguments[1]) : 1.0;
    // Levels that are busy all the time, with real-time priorities, would leave this thread, and
    // whatever else the machine does, next to nothing.
    if (!start({.real_time = false})) return 2;
    Monitor monitor;
    while (wait_until(clock_us() + 100) == Ending::kTime &&
           static_cast<double>(clock_us()) < seconds * 1e6) {
        for (int i = 0; i < 20; ++i) monitor.look();
    }
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
    std::printf("the link read %u samples\n", monitor.samples());
    require(monitor.samples() > 0, "stress: the link read nothing");
    return 0;
}
