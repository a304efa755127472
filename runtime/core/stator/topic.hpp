// A topic: slots that one level or more publishes into and readers of other levels read in place.
//
// Jobs run to completion on one stack and nest like brackets, so one word says which slots are
// free: a reader saves the word and clears the bit of the slot it takes, and restores the word when
// it is done; whoever preempts in between puts back what it found. Publishing finds a free slot
// with one load and one count-leading-zeros, whatever the number of readers. Safety rests on no
// timing. docs/topics.md has the argument and the slot formula; the explorer in tests/runtime/core
// runs this code under every preemption schedule of small topologies.
#pragma once

#include <atomic>
#include <bit>
#include <cstdint>

#include "stator/executor.hpp"

namespace stator {

// A word that jobs of several levels share on one core: plain loads and stores, never reordered by
// the compiler against the samples they guard. Every access is a preemption point (a no-op except
// in the virtual executor and the explorer).
template <class Value>
class Shared {
  public:
    constexpr Shared() = default;
    explicit constexpr Shared(Value value) : value_(value) {}

    Value load() const {
        preemption_point();
        std::atomic_signal_fence(std::memory_order_seq_cst);
        const Value value = value_.load(std::memory_order_relaxed);
        std::atomic_signal_fence(std::memory_order_seq_cst);
        return value;
    }
    void store(Value value) {
        preemption_point();
        std::atomic_signal_fence(std::memory_order_seq_cst);
        value_.store(value, std::memory_order_relaxed);
        std::atomic_signal_fence(std::memory_order_seq_cst);
    }

  private:
    std::atomic<Value> value_{};
};

// A time that one level writes and lower ones read, in two words: read again if the upper one
// changed in between.
class SharedTime {
  public:
    uint64_t load() const {
        uint32_t low = 0;
        uint32_t high = high_.load();
        for (uint32_t before = ~high; before != high; high = high_.load()) {
            before = high;
            low = low_.load();
        }
        return (uint64_t{high} << 32) | low;
    }
    void store(uint64_t time_us) {
        high_.store(static_cast<uint32_t>(time_us >> 32));
        low_.store(static_cast<uint32_t>(time_us));
    }

  private:
    Shared<uint32_t> high_;
    Shared<uint32_t> low_;
};

// Slot 0 is the top bit, so that count-leading-zeros gives the index of a free slot.
inline constexpr unsigned kMaxSlots = 32;
constexpr uint32_t slot_mask(unsigned slot) {
    return 0x80000000U >> slot;
}
constexpr uint32_t all_slots(unsigned slots) {
    return ~0U << (kMaxSlots - slots);
}

// What of a topic changes at run time.
struct TopicState {
    Shared<uint32_t> free;     // slots that nobody reads or builds
    Shared<uint32_t> history;  // slots of the `depth` newest samples; 0 before the first
    Shared<uint32_t> head;     // number of the newest sample; counts from 1 and wraps
};

// A subscriber that `min_interval` thins: pended when a sample's timestamp reaches `due_us`, which
// advances by whole intervals, so that the mean rate is kept.
struct ThinnedState {
    uint64_t due_us = 0;
    Shared<uint32_t> fires;
};
struct Thinned {
    ThinnedState* state;
    uint32_t interval_us;
    Pend pend;
};

// One row of the generated topic table; constant.
struct Topic {
    TopicState* state;
    void* samples;             // `slots` samples of the message
    Shared<uint32_t>* number;  // per slot: the number of its sample
    Shared<uint8_t>* ring;     // 2 * depth slots, newest last; unused at depth 1
    const Pend* subscribers;
    const Thinned* thinned;
    uint16_t sample_bytes;
    uint8_t subscriber_count;
    uint8_t thinned_count;
    uint8_t slots;
    uint8_t depth;    // power of two
    uint8_t ceiling;  // highest publishing level if several levels publish, else 0
};

// A slot in use by a job: what to put back into `free` at its end.
struct Pin {
    uint32_t saved_free = 0;
    uint32_t slot = 0;
};

// Number of the sample in a slot that the caller holds.
inline uint32_t number_of(const Topic& topic, const Pin& pin) {
    return topic.number[pin.slot].load();
}

// The functions that take have `marks`. False: no publisher of the topic can run before the pin is
// released, as none outranks the reader; then no slot needs to be marked.

// On one core, no take is older than the one before, so that nobody tells what was seen.
inline constexpr bool kTakesNeedSeen = false;

// Takes the newest sample. False if there is none yet: then nothing is held.
// Constant time; any context above hardware priority 0.
inline bool take_latest(const Topic& topic, uint32_t /*seen*/, Pin& pin, bool marks = true) {
    TopicState& state = *topic.state;
    uint32_t mask = state.history.load();
    if (mask == 0) return false;
    if (topic.depth == 1) {
        pin.slot = static_cast<uint32_t>(std::countl_zero(mask));
    } else {
        const uint32_t head = state.head.load();
        pin.slot = topic.ring[(head - 1) & (2U * topic.depth - 1)].load();
        mask = slot_mask(pin.slot);
    }
    if (!marks) return true;
    pin.saved_free = state.free.load();
    state.free.store(pin.saved_free & ~mask);
    return true;
}

inline void release(const Topic& topic, const Pin& pin, bool marks = true) {
    if (marks) topic.state->free.store(pin.saved_free);
}

// Takes the oldest sample after number `cursor`, moves `cursor` on to it and adds to `lost` what
// the history no longer holds. False if there is none. A round repeats only if a publication
// overtook it: at most once per activation of a publisher that preempts it.
inline bool take_next(const Topic& topic, uint32_t& cursor, uint32_t& lost, Pin& pin,
                      bool marks = true) {
    TopicState& state = *topic.state;
    if (topic.depth == 1) {
        if (!take_latest(topic, cursor, pin, marks)) return false;
        const uint32_t number = number_of(topic, pin);
        if (number == cursor) {
            release(topic, pin, marks);
            return false;
        }
        lost += number - cursor - 1;
        cursor = number;
        return true;
    }
    const uint32_t depth = topic.depth;
    if (marks) pin.saved_free = state.free.load();
    uint32_t next = 0;
    do {
        next = cursor;
        const uint32_t head = state.head.load();
        if (head == next) {
            release(topic, pin, marks);
            return false;
        }
        if (head - next > depth) next = head - depth;
        pin.slot = topic.ring[next & (2 * depth - 1)].load();
        if (!marks) break;
        state.free.store(pin.saved_free & ~slot_mask(pin.slot));
    } while (state.head.load() - next > depth);
    lost += next - cursor;
    cursor = next + 1;
    return true;
}

// True if a sample after number `cursor` was published.
inline bool has_unread(const Topic& topic, uint32_t cursor) {
    return topic.state->head.load() != cursor;
}

// A slot to build one sample in, until `commit`.
struct Loan {
    uint32_t saved_free = 0;
    uint32_t slot = 0;
};

// The common case, worth a short path: only the newest sample counts, and one level publishes.
inline bool is_plain(const Topic& topic) {
    return topic.depth == 1 && topic.ceiling == 0;
}

// Samples of the history that a publisher may not overwrite. Without `keep` no reader outranks it,
// so the oldest one may be overwritten in place.
inline uint32_t kept_history(const Topic& topic, bool keep) {
    const uint32_t history = topic.state->history.load();
    if (keep || std::popcount(history) < topic.depth) return history;
    if (topic.depth == 1) return 0;
    const uint32_t oldest = topic.state->head.load() - topic.depth;
    return history & ~slot_mask(topic.ring[oldest & (2U * topic.depth - 1)].load());
}

[[gnu::noinline]] inline Loan loan_in_history(const Topic& topic, bool keep) {
    const Section section(topic.ceiling);
    const uint32_t free = topic.state->free.load();
    const uint32_t usable = free & ~kept_history(topic, keep);
    require(usable != 0, "topic: no free slot");
    const auto slot = static_cast<uint32_t>(std::countl_zero(usable));
    if (topic.ceiling != 0) topic.state->free.store(free & ~slot_mask(slot));
    return {free, slot};
}

// Finds a slot that nobody reads. The compiler's slot count makes sure there is one. `keep`: a
// reader outranks this publisher.
inline Loan loan(const Topic& topic, bool keep) {
    if (!is_plain(topic)) return loan_in_history(topic, keep);
    const uint32_t free = topic.state->free.load();
    const uint32_t usable = keep ? free & ~topic.state->history.load() : free;
    require(usable != 0, "topic: no free slot");
    return {free, static_cast<uint32_t>(std::countl_zero(usable))};
}

[[gnu::noinline]] inline void commit_to_history(const Topic& topic, Loan loaned) {
    TopicState& state = *topic.state;
    const Section section(topic.ceiling);
    const uint32_t head = state.head.load();
    topic.number[loaned.slot].store(head + 1);
    uint32_t history = state.history.load();
    if (topic.depth == 1) {
        state.history.store(slot_mask(loaned.slot));
        state.head.store(head + 1);
    } else {
        const uint32_t last = 2U * topic.depth - 1;
        const auto slot = static_cast<uint8_t>(loaned.slot);
        if (std::popcount(history) == topic.depth) {
            history &= ~slot_mask(topic.ring[(head - topic.depth) & last].load());
        }
        topic.ring[head & last].store(slot);
        state.head.store(head + 1);
        state.history.store(history | slot_mask(loaned.slot));
    }
    if (topic.ceiling != 0) state.free.store(loaned.saved_free);
}

// Makes the sample the newest one. `head` is the one commit point for queue readers, `history` for
// readers of the newest at depth 1.
inline void commit(const Topic& topic, Loan loaned) {
    if (!is_plain(topic)) return commit_to_history(topic, loaned);
    const uint32_t number = topic.state->head.load() + 1;
    topic.number[loaned.slot].store(number);
    topic.state->history.store(slot_mask(loaned.slot));
    topic.state->head.store(number);
}

// Pends the thinned subscribers that are due. In one section: another publisher must not come in
// between, and all are pended before any runs.
[[gnu::noinline]] inline void pend_thinned(const Topic& topic, uint64_t timestamp_us) {
    const Section section(topic.ceiling);
    for (unsigned i = 0; i < topic.thinned_count; ++i) {
        const Thinned& thinned = topic.thinned[i];
        if (timestamp_us < thinned.state->due_us) continue;
        const uint64_t late = timestamp_us - thinned.state->due_us;
        thinned.state->due_us += (late / thinned.interval_us + 1) * thinned.interval_us;
        thinned.state->fires.store(thinned.state->fires.load() + 1);
        set_pending(thinned.pend);
    }
}

// Wakes the subscribers of a topic whose newest sample is stamped `timestamp_us`. Of a constant row
// only the stores are left.
inline void activate(const Topic& topic, uint64_t timestamp_us) {
    for (unsigned i = 0; i < topic.subscriber_count; ++i) set_pending(topic.subscribers[i]);
    if (topic.thinned_count != 0) pend_thinned(topic, timestamp_us);
    if (topic.subscriber_count + topic.thinned_count != 0) preempt();
}

}  // namespace stator
