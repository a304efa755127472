// Topics between threads that tests make by hand; the tests are those of tests/runtime/core.
#pragma once

#include <gtest/gtest.h>

#include <array>

#include "stator/port.hpp"

namespace stator::testing {

inline constexpr Pend kHigh{0, 1};  // of a level that does not run

// True if the ring and the slots agree on who reads what, and nobody does.
inline bool is_at_rest(const Topic& topic) {
    std::array<uint32_t, kMaxSlots> readers{};  // in the ring's words: not yet noted in the slots
    unsigned in_ring = 0;
    for (unsigned i = 0; i < topic.depth; ++i) {
        const uint64_t entry = topic.ring[i].word.load();
        if (slot_of(entry) == kNoSlot) continue;
        ++in_ring;
        readers[slot_of(entry)] += readers_of(entry);
        if (!topic.users[slot_of(entry)].is_live) return false;
    }
    for (const Kept& kept : topic.state->kept) {
        if (kept.holds != 0) return false;
        if (kept.is_kept) --readers[kept.slot];  // not done yet
    }
    unsigned live = 0;
    for (unsigned slot = 0; slot < topic.slots; ++slot) {
        const SlotState& user = topic.users[slot];
        live += user.is_live ? 1U : 0U;
        if (((user.done.load() - user.taken - readers[slot]) & kReaderMask) != 0) return false;
    }
    return live == in_ring;
}

// A topic with its storage. `first`: the number before the first sample. One slot more than on one
// core, for the sample that a level keeps; what is too few there stays too few.
template <class Message, unsigned depth, unsigned slots_on_one_core, unsigned ceiling = 0>
struct TopicOf {
    static constexpr unsigned slots = slots_on_one_core + (slots_on_one_core > 1 ? 1 : 0);
    std::array<Message, slots> samples{};
    std::array<RingEntry, depth> ring{};
    std::array<SlotState, slots> users{};
    TopicState state{};
    Mutex mutex{};
    Topic topic{.state = &state,
                .samples = samples.data(),
                .ring = ring.data(),
                .users = users.data(),
                .mutex = ceiling != 0 ? &mutex : nullptr,
                .subscribers = nullptr,
                .thinned = nullptr,
                .sample_bytes = sizeof(Message),
                .subscriber_count = 0,
                .thinned_count = 0,
                .slots = slots,
                .depth = depth};

    explicit TopicOf(uint32_t first = 0) { state.head.store(first); }
    bool is_idle() const { return is_at_rest(topic); }
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

class TopicTest : public ::testing::Test {};

}  // namespace stator::testing
