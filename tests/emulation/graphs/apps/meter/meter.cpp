// Counts the instructions of one way through the runtime after the other, and prints.
#include "meter.hpp"

#include "../../../../../boards/qemu_f405/semihosting.hpp"
#include "../../counting.hpp"

namespace stator::apps::meter {

namespace {

constexpr uint32_t kRuns = 500;
constexpr uint32_t kUncounted = 20;  // until `other` has published
// A reading of the counter stands at each end of a way; one of them is counted.
constexpr uint32_t kReading = 1;

// What stands before it is done, and what stands behind it is not begun.
[[gnu::always_inline]] inline uint32_t now() {
    asm volatile("" ::: "memory");
    const uint32_t count = counting::kCount.read();
    asm volatile("" ::: "memory");
    return count;
}
uint32_t at(counting::Place place) {
    return counting::reached[static_cast<unsigned>(place)];
}
void pend(unsigned vector) {
    nvic::set_pending(vector / 32).write(1U << vector % 32);
}

// Alike for every vector.
[[gnu::noipa]] uint32_t read_and_pend(unsigned vector) {
    const uint32_t begin = now();
    pend(vector);
    return begin;
}

[[gnu::always_inline]] inline void publish_by_hand(uint64_t time_us, uint32_t value) {
    counting::WrittenByHand& topic = counting::written_by_hand;
    const uint32_t next = topic.newest.load() ^ 1U;
    topic.slots[next] = {.timestamp = time_us,
                         .values = {value, value, value, value, value, value}};
    topic.newest.store(next);
}

}  // namespace

void Meter::note(Way way, uint32_t count) {
    Range& range = ranges_[way];
    range.least = count < range.least ? count : range.least;
    range.most = count > range.most ? count : range.most;
}

void Meter::step(MeterPorts& ports) {
    using counting::Place;
    const uint32_t value = ++runs_;
    if (value <= kUncounted) ranges_.fill({});
    const uint64_t time_us = ports.now;
    const auto block = [value] {
        return Block{.values = {value, value, value, value, value, value}};
    };
    asm volatile("" ::"r"(time_us));  // known before anything is counted

    uint32_t begin = now();
    ports.awaited.publish(block);
    note(kPublishToStep, at(Place::kStep) - begin - kReading);

    begin = now();
    ports.both.publish(block);
    note(kPublishToStepOfBoth, at(Place::kStep) - begin - kReading);

    begin = now();
    ports.quiet.publish(block);
    note(kPublish, now() - begin - kReading);

    begin = now();
    publish_by_hand(time_us, value);
    pend(counting::kByHandVector);
    note(kWrittenByHandToHandler, at(Place::kByHand) - begin - kReading);

    begin = now();
    publish_by_hand(time_us, value);
    note(kWrittenByHand, now() - begin - kReading);

    // Until a handler is entered: the same instructions for both.
    begin = read_and_pend(counting::kEntryVector);
    const uint32_t entered = at(Place::kEntry) - begin;
    begin = read_and_pend(counting::kProbeVector);
    note(kInterruptToDriver, at(Place::kDriver) - begin - entered);

    begin = now();
    ports.first.publish(block);
    note(kActivation, now() - begin);
    begin = now();
    ports.second.publish(block);
    note(kActivationWithLatest, now() - begin);

    ports.shared.publish(block);
    ports.queue.publish(block);
    if (runs_ == kRuns) print();
}

void Meter::print() const {
    for (const Range& range : ranges_) {
        semihosting::print(range.least);
        semihosting::print(" ");
        semihosting::print(range.most);
        semihosting::print("\n");
    }
    semihosting::exit(0);
}

}  // namespace stator::apps::meter
