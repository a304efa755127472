// A topic of one core: slots that one level or more publishes into and readers of other levels
// read in place. The executors of one core have it as their "stator/topic.hpp".
//
// Jobs run to completion on one stack and nest like brackets, so one word says which slots are
// free: a reader saves the word and clears the bit of the slot it takes, and restores the word when
// it is done; a job that preempts in between puts back what it found. Publishing finds a free slot
// with one load and one count-leading-zeros, whatever the number of readers. Safety rests on no
// timing. docs/topics.md has the argument and the slot formula; the explorer in tests/runtime/core
// runs this code under every preemption schedule of small topologies.
#pragma once

#include <atomic>
#include <bit>
#include <cstddef>
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

    [[gnu::always_inline]] Value load() const {
        preemption_point();
        std::atomic_signal_fence(std::memory_order_seq_cst);
        const Value value = value_.load(std::memory_order_relaxed);
        std::atomic_signal_fence(std::memory_order_seq_cst);
        return value;
    }
    [[gnu::always_inline]] void store(Value value) {
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

// What of a topic changes at run time. Neighbours are loaded and stored together, the first one
// first: on Arm by one instruction, which an exception may split, but not turn round.
struct TopicState {
    Shared<uint32_t> free;     // slots that nobody reads or builds
    Shared<uint32_t> history;  // slots of the `depth` newest samples; 0 before the first
    Shared<uint32_t> head;     // number of the newest sample; counts from 1 and wraps

#ifdef __ARM_ARCH_7EM__
    [[gnu::always_inline]] void load(uint32_t& free_now, uint32_t& history_now) const {
        asm volatile("ldrd %0, %1, %2"
                     : "=r"(free_now), "=r"(history_now)
                     : "m"(two(free))
                     : "memory");
    }
    [[gnu::always_inline]] void store(uint32_t new_history, uint32_t new_head) {
        asm volatile("strd %1, %2, %0"
                     : "=m"(two(history))
                     : "r"(new_history), "r"(new_head)
                     : "memory");
    }

  private:
    using Two [[gnu::may_alias, gnu::aligned(4)]] = uint64_t;  // as wide as the address must suit
    static Two& two(Shared<uint32_t>& first) {
        return reinterpret_cast<Two&>(first);
    }
    static const Two& two(const Shared<uint32_t>& first) {
        return reinterpret_cast<const Two&>(first);
    }
#else
    void load(uint32_t& free_now, uint32_t& history_now) const {
        free_now = free.load();
        history_now = history.load();
    }
    void store(uint32_t new_history, uint32_t new_head) {
        history.store(new_history);
        head.store(new_head);
    }
#endif
};

// The same of a topic of depth 1 that one level publishes and that no lower level reads, nor its
// publisher: no job holds a sample while the next but one is built, so its one or two slots take
// turns. Sample n lies in slot n modulo their count.
struct TurnState {
    Shared<const std::byte*> newest;  // null before the first
    Shared<uint32_t> head;            // its number; stored behind it
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
struct InSection;
struct Topic {
    TopicState* state;         // unused where slots take turns
    void* samples;             // `slots` samples of the message
    Shared<uint32_t>* number;  // per slot: the number of its sample; unused where slots take turns
    Shared<uint32_t>* ring;    // the last 2 * depth samples, as masks; unused at depth 1
    const Pend* subscribers;   // one entry for each word that subscribers' bits lie in
    const Thinned* thinned;
    const InSection* in_section;  // if several levels publish
    uint16_t sample_bytes;
    uint8_t subscriber_count;
    uint8_t thinned_count;
    uint8_t slots;
    uint8_t depth;               // power of two
    uint8_t ceiling;             // highest publishing level if several levels publish, else 0
    TurnState* turns = nullptr;  // if its slots take turns
    Shared<const std::byte*>* newest = nullptr;  // for readers that `take_woken`
};

// A slot in use by a job: what to put back into `free` at its end.
struct Pin {
    uint32_t saved_free = 0;
    uintptr_t slot = 0;  // where slots take turns, or `is_woken`: the address of the sample
};

[[gnu::always_inline]] inline std::byte* slot_at(const Topic& topic, uint32_t slot) {
    return static_cast<std::byte*>(topic.samples) + size_t{slot} * topic.sample_bytes;
}
// The sample that the caller holds. `is_woken`: taken by `take_woken`.
[[gnu::always_inline]] inline const std::byte* sample_of(const Topic& topic, const Pin& pin,
                                                         bool is_woken = false) {
    if (topic.turns != nullptr || is_woken) return std::bit_cast<const std::byte*>(pin.slot);
    return slot_at(topic, static_cast<uint32_t>(pin.slot));
}

[[gnu::always_inline]] inline const Shared<uint32_t>& head_of(const Topic& topic) {
    return topic.turns != nullptr ? topic.turns->head : topic.state->head;
}

// Its number.
[[gnu::always_inline]] inline uint32_t number_of(const Topic& topic, const Pin& pin,
                                                 bool is_woken = false) {
    if (is_woken) return head_of(topic).load();
    if (topic.turns == nullptr) return topic.number[pin.slot].load();
    const uint32_t head = topic.turns->head.load();
    if (topic.slots == 1) return head;
    // A publisher that this reader outranks may be between its two stores.
    const uint32_t slot = sample_of(topic, pin) == topic.samples ? 0 : 1;
    return head + ((head ^ slot) & 1U);
}

// The functions that take have `marks`. False: no publisher of the topic can run before the pin is
// released, as none outranks the reader; then no slot needs to be marked.

// On one core, no take is older than the one before, so that nobody tells what was seen.
inline constexpr bool kTakesNeedSeen = false;

// Whether a sample stays as it is until its publisher publishes again: so it is where no other
// level publishes. Then it can be recorded behind the commit.
inline bool is_kept_for_publisher(const Topic& topic) {
    return topic.ceiling == 0;
}

// Takes the newest sample. False if there is none yet: then nothing is held, and what was saved may
// be put back all the same.
// Constant time; any context above hardware priority 0.
[[gnu::always_inline]] inline bool take_latest(const Topic& topic, uint32_t /*seen*/, Pin& pin,
                                               bool marks = true) {
    if (topic.turns != nullptr) {
        pin.slot = reinterpret_cast<uintptr_t>(topic.turns->newest.load());
        return pin.slot != 0;
    }
    TopicState& state = *topic.state;
    if (marks) pin.saved_free = state.free.load();
    uint32_t mask = state.history.load();
    if (mask == 0) return false;
    if (topic.depth != 1) {
        const uint32_t head = state.head.load();
        mask = topic.ring[(head - 1) & (2U * topic.depth - 1)].load();
    }
    pin.slot = static_cast<unsigned>(std::countl_zero(mask));
    if (!marks) return true;
    state.free.store(pin.saved_free & ~mask);
    return true;
}

// The same for a reader that a sample has woken, so that there is one, and that no publisher
// outranks.
[[gnu::always_inline]] inline void take_woken(const Topic& topic, uint32_t /*seen*/, Pin& pin) {
    pin.slot = reinterpret_cast<uintptr_t>(topic.newest->load());
    if (pin.slot == 0) __builtin_unreachable();
}

[[gnu::always_inline]] inline void release(const Topic& topic, const Pin& pin, bool marks = true) {
    if (marks && topic.turns == nullptr) topic.state->free.store(pin.saved_free);
}

// Takes the oldest sample after number `cursor`, moves `cursor` on to it and adds to `lost` what
// the history no longer holds. False if there is none. A round repeats only if a publication
// overtook it: at most once per activation of a publisher that preempts it.
[[gnu::always_inline]] inline bool take_next(const Topic& topic, uint32_t& cursor, uint32_t& lost,
                                             Pin& pin, bool marks = true) {
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
    TopicState& state = *topic.state;
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
        const uint32_t mask = topic.ring[next & (2 * depth - 1)].load();
        pin.slot = static_cast<unsigned>(std::countl_zero(mask));
        if (!marks) break;
        state.free.store(pin.saved_free & ~mask);
    } while (state.head.load() - next > depth);
    lost += next - cursor;
    cursor = next + 1;
    return true;
}

// True if a sample after number `cursor` was published.
[[gnu::always_inline]] inline bool has_unread(const Topic& topic, uint32_t cursor) {
    return head_of(topic).load() != cursor;
}

// A slot to build one sample in, until `commit`.
struct Loan {
    uint32_t word = 0;  // what `free` was; where slots take turns, the number of the sample
    uint32_t slot = 0;
};

// Samples of the history that a publisher may not overwrite. Without `keep` no reader outranks it,
// so the oldest one may be overwritten in place.
[[gnu::always_inline]] inline uint32_t kept_history(const Topic& topic, bool keep) {
    if (topic.depth == 1 && !keep) return 0;
    const uint32_t history = topic.state->history.load();
    if (keep) return history;
    const uint32_t oldest = topic.state->head.load() - topic.depth;
    return history & ~topic.ring[oldest & (2U * topic.depth - 1)].load();
}

// Where several levels publish, one must not come between another one's loads and stores. Each such
// topic has these three by itself, under its name: nothing else in an image raises BASEPRI.
struct InSection {
    Loan (*loan)(const Topic& topic, bool keep);
    uint32_t (*commit)(const Topic& topic, Loan loaned, const std::byte* sample);
    bool (*is_due)(const Topic& topic, const Thinned& thinned, uint64_t timestamp_us);
};

[[gnu::always_inline]] inline Loan find_slot(const Topic& topic, bool keep) {
    uint32_t free = 0;
    uint32_t kept = 0;
    if (topic.depth == 1 && keep) {
        topic.state->load(free, kept);
    } else {
        free = topic.state->free.load();
        kept = kept_history(topic, keep);
    }
    const uint32_t usable = free & ~kept;
    require(usable != 0, "topic: no free slot");
    return {free, static_cast<uint32_t>(std::countl_zero(usable))};
}
[[gnu::always_inline]] inline Loan loan_in_section(const Topic& topic, bool keep) {
    const Section section(topic.ceiling);
    const Loan loaned = find_slot(topic, keep);
    topic.state->free.store(loaned.word & ~slot_mask(loaned.slot));
    return loaned;
}

// Finds a slot that nobody reads. The compiler's slot count makes sure there is one. `keep`: a
// reader outranks this publisher.
[[gnu::always_inline]] inline Loan loan(const Topic& topic, bool keep) {
    if (topic.turns != nullptr) {
        const uint32_t number = topic.turns->head.load() + 1;
        return {number, number & (topic.slots - 1U)};
    }
    return topic.ceiling != 0 ? topic.in_section->loan(topic, keep) : find_slot(topic, keep);
}

// Returns the sample's number.
[[gnu::always_inline]] inline uint32_t append(const Topic& topic, Loan loaned,
                                              const std::byte* sample) {
    TopicState& state = *topic.state;
    const uint32_t head = state.head.load();
    const uint32_t mask = slot_mask(loaned.slot);
    topic.number[loaned.slot].store(head + 1);
    if (topic.depth == 1) {
        if (topic.newest != nullptr) topic.newest->store(sample);
        state.store(mask, head + 1);
        return head + 1;
    }
    const uint32_t last = 2U * topic.depth - 1;
    const uint32_t oldest = topic.ring[(head - topic.depth) & last].load();
    const uint32_t history = state.history.load() & ~oldest;
    topic.ring[head & last].store(mask);
    state.head.store(head + 1);
    state.history.store(history | mask);
    return head + 1;
}
[[gnu::always_inline]] inline uint32_t commit_in_section(const Topic& topic, Loan loaned,
                                                         const std::byte* sample) {
    const Section section(topic.ceiling);
    const uint32_t number = append(topic, loaned, sample);
    topic.state->free.store(loaned.word);
    return number;
}

// Makes the sample the newest one. `head` is the one commit point for queue readers, `history` for
// readers of the newest at depth 1, and `newest` where slots take turns. `sample`: what was built
// in the slot. Returns the sample's number.
[[gnu::always_inline]] inline uint32_t commit(const Topic& topic, Loan loaned,
                                              const std::byte* sample) {
    if (topic.turns != nullptr) {
        topic.turns->newest.store(sample);
        topic.turns->head.store(loaned.word);
        return loaned.word;
    }
    return topic.ceiling != 0 ? topic.in_section->commit(topic, loaned, sample)
                              : append(topic, loaned, sample);
}

// Of 64 bits a division takes some hundred instructions: only after a pause.
inline uint64_t next_due_us(uint64_t due_us, uint64_t timestamp_us, uint32_t interval_us) {
    const uint64_t late = timestamp_us - due_us;
    if (late < interval_us) return due_us + interval_us;
    return due_us + (late / interval_us + 1) * interval_us;
}

// True if a sample of this time is due; then counts it, and the next one is due later.
[[gnu::always_inline]] inline bool is_due_in_section(const Topic& topic, const Thinned& thinned,
                                                     uint64_t timestamp_us) {
    ThinnedState& state = *thinned.state;
    while (true) {
        uint64_t due_us = 0;
        {
            const Section section(topic.ceiling);
            due_us = state.due_us;
        }
        if (timestamp_us < due_us) return false;
        const uint64_t next_us = next_due_us(due_us, timestamp_us, thinned.interval_us);
        preemption_point();
        const Section section(topic.ceiling);
        if (state.due_us != due_us) continue;  // another publisher came in between
        state.due_us = next_us;
        state.fires.store(state.fires.load() + 1);
        return true;
    }
}
inline bool is_due(const Topic& topic, const Thinned& thinned, uint64_t timestamp_us) {
    if (topic.ceiling != 0) return topic.in_section->is_due(topic, thinned, timestamp_us);
    ThinnedState& state = *thinned.state;
    if (timestamp_us < state.due_us) return false;
    state.due_us = next_due_us(state.due_us, timestamp_us, thinned.interval_us);
    state.fires.store(state.fires.load() + 1);
    return true;
}

// For topics that several levels publish and that stand in no image's table, as in tests.
inline constexpr InSection kInSection{loan_in_section, commit_in_section, is_due_in_section};

// Wakes the subscribers of a topic whose newest sample is stamped `timestamp_us`: first finds out
// who is due, then pends with one store for each word, so that the most urgent of all runs first.
// Of a constant row only the tests of thinned subscribers and the stores are left.
[[gnu::always_inline]] inline void activate(const Topic& topic, uint64_t timestamp_us) {
    uint32_t due = 0;
    for (unsigned i = 0; i < topic.thinned_count; ++i) {
        if (is_due(topic, topic.thinned[i], timestamp_us)) due |= 1U << i;
    }
    for (unsigned i = 0; i < topic.subscriber_count; ++i) {
        Pend pend = topic.subscribers[i];
        for (unsigned k = 0; k < topic.thinned_count; ++k) {
            const Pend& thinned = topic.thinned[k].pend;
            if ((due >> k & 1U) != 0 && thinned.word == pend.word) pend.mask |= thinned.mask;
        }
        if (pend.mask != 0) set_pending(pend);
    }
    if (topic.subscriber_count != 0) preempt();
}

}  // namespace stator
