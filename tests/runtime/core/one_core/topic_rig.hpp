// The smallest program for the virtual executor, and topics that tests make by hand.
#pragma once

#include <gtest/gtest.h>

#include <array>
#include <functional>

#include "stator/port.hpp"
#include "stator/virtual.hpp"

namespace stator::testing {

// What the tasks of levels 3, 2 and 1 do; bit i of the pending word is jobs[i].
extern std::array<std::function<void()>, 3> jobs;
extern uint64_t pending[1];
inline constexpr Pend kHigh{0, 1};
inline constexpr Pend kMiddle{0, 2};
inline constexpr Pend kLow{0, 4};

// Before each test: nobody has anything to do.
void begin();

// A topic with its storage. `first`: the number before the first sample.
template <class Message, unsigned depth, unsigned slots, unsigned ceiling = 0>
struct TopicOf {
    std::array<Message, slots> samples{};
    std::array<Shared<uint32_t>, slots> number{};
    std::array<Shared<uint32_t>, 2 * depth> ring{};
    TopicState state{Shared<uint32_t>(all_slots(slots)), {}, {}};
    Topic topic{.state = &state,
                .samples = samples.data(),
                .number = number.data(),
                .ring = ring.data(),
                .subscribers = nullptr,
                .thinned = nullptr,
                .in_section = &kInSection,
                .sample_bytes = sizeof(Message),
                .subscriber_count = 0,
                .thinned_count = 0,
                .slots = slots,
                .depth = depth,
                .ceiling = ceiling};

    explicit TopicOf(uint32_t first = 0) { state.head.store(first); }
    bool is_idle() const { return state.free.load() == all_slots(slots); }
};

template <class Message>
void publish(const Topic& topic, const Message& message, uint64_t now_us, bool keep = true) {
    Output<Message> output;
    output.connect(topic, now_us, keep);
    output.publish([&] { return message; });
}

struct Reading {
    uint64_t timestamp;
    uint32_t value;
    uint32_t _padding0;
};

// Nobody has anything to do when a test begins.
class TopicTest : public ::testing::Test {
  protected:
    TopicTest() { begin(); }
};

}  // namespace stator::testing
