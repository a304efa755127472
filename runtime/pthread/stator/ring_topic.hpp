// A topic between threads that truly run at once: a ring of the newest samples, in which each entry
// counts who has taken it. This executor has it as its "stator/topic.hpp".
//
// An entry is one 64-bit word: {readers:24 | slot:8 | sequence:32}. A reader takes a sample by
// adding one reader to its entry, which also tells it the slot, and is done when it has counted
// itself off in the slot. A publisher exchanges the oldest entry for its sample, learns by that how
// many took the old one, and builds in that slot again once as many are done. Readers never wait
// and never retry; publishers of one level never wait; those of several levels share a mutex, which
// is not held while a message is built. docs/topics.md has the argument and the slot formula.
//
// For one sample and one publisher this is the register of Ianni, Pellegrini and Quaglia,
// "Anonymous Readers Counting" (arXiv 1707.07478).
#pragma once

#include <atomic>
#include <bit>
#include <cstddef>
#include <cstdint>

#include "stator/executor.hpp"
#include "stator/mutex.hpp"

namespace stator {

// A word that threads share: what was written before a store is seen after the load that finds it.
template <class Value>
class Shared {
  public:
    constexpr Shared() = default;
    explicit constexpr Shared(Value value) : value_(value) {}
    Value load() const { return value_.load(std::memory_order_acquire); }
    void store(Value value) { value_.store(value, std::memory_order_release); }

  private:
    std::atomic<Value> value_{};
};

using SharedTime = Shared<uint64_t>;

// --- the words of a ring ---

inline constexpr uint64_t kOneReader = uint64_t{1} << 40;  // what overflows falls off the top
inline constexpr uint32_t kReaderMask = (1U << 24) - 1;
inline constexpr uint8_t kNoSlot = 255;
inline constexpr unsigned kMaxSlots = 254;

constexpr uint64_t entry_of(uint32_t sequence, uint8_t slot) {
    return (uint64_t{slot} << 32) | sequence;
}
constexpr uint8_t slot_of(uint64_t entry) {
    return static_cast<uint8_t>(entry >> 32);
}
constexpr uint32_t sequence_of(uint64_t entry) {
    return static_cast<uint32_t>(entry);
}
constexpr uint32_t readers_of(uint64_t entry) {
    return static_cast<uint32_t>(entry >> 40);
}

// An entry before the first publication.
struct RingEntry {
    std::atomic<uint64_t> word{entry_of(0, kNoSlot)};
};

// Who uses a slot. `done` only ever counts up, so that no store can cross a reader's.
struct SlotState {
    std::atomic<uint32_t> done{0};  // readers that are done with it
    uint32_t taken = 0;             // readers that took it; of publishers, and so is the next
    bool is_live = false;           // in the ring, or on loan
};

// A sample in use by a job. `is_kept`: its level keeps it beyond the job.
struct Pin {
    uint32_t number = 0;
    uint8_t slot = 0;
    bool is_kept = false;
};

// What a level has read as the newest. It keeps it until it reads a newer one while no job holds
// it: until then, reading it again is a load and a comparison.
struct Kept : Pin {
    uint32_t holds = 0;  // of the job that runs
};

struct TopicState {
    std::atomic<uint32_t> head{0};  // number of the newest sample; counts from 1 and wraps
    // Each of that level's thread alone; the last one is of threads that are no level.
    Kept kept[kMaxLevels + 1];
};

// --- tables ---

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
    void* samples;     // `slots` samples of the message
    RingEntry* ring;   // `depth` entries
    SlotState* users;  // of each slot
    Mutex* mutex;      // of publishers on several levels, else null
    const Pend* subscribers;
    const Thinned* thinned;
    uint16_t sample_bytes;
    uint8_t subscriber_count;
    uint8_t thinned_count;
    uint8_t slots;
    uint8_t depth;  // power of two
};

// --- readers ---

// Readers tell what they have seen: see `take_latest`. `marks` and `keep` are of topics on one
// core; here every reader counts, and every sample of the ring is kept.
inline constexpr bool kTakesNeedSeen = true;

// Readers of other threads have the sample at once, and who publishes next may reuse its slot.
inline bool is_kept_for_publisher(const Topic&) {
    return false;
}

inline uint32_t number_of(const Topic&, const Pin& pin, bool /*is_woken*/ = false) {
    return pin.number;
}
inline std::byte* slot_at(const Topic& topic, uint8_t slot) {
    return static_cast<std::byte*>(topic.samples) + size_t{slot} * topic.sample_bytes;
}
// The sample in a slot that the caller holds.
inline const std::byte* sample_of(const Topic& topic, const Pin& pin, bool /*is_woken*/ = false) {
    return slot_at(topic, pin.slot);
}
inline const std::atomic<uint32_t>& head_of(const Topic& topic) {
    return topic.state->head;
}

// Counts the reader in. Acquire: the sample is whole. Release: a thread that sees this reader in
// the entry also sees that its earlier pins are done; with acquire alone a publisher may find no
// free slot (never on x86, and no sanitizer shows it).
inline void pin_entry(const Topic& topic, uint32_t sequence, Pin& pin) {
    std::atomic<uint64_t>& word = topic.ring[sequence & (topic.depth - 1U)].word;
    const uint64_t entry = word.fetch_add(kOneReader, std::memory_order_acq_rel);
    pin.slot = slot_of(entry);
    pin.number = sequence_of(entry) + 1;
}

// Release: the publisher that sees this reader done does not write before its last read.
inline void unpin(const Topic& topic, const Pin& pin) {
    topic.users[pin.slot].done.fetch_add(1, std::memory_order_release);
}
inline void release(const Topic& topic, const Pin& pin, bool /*marks*/ = true) {
    if (pin.is_kept) {
        --topic.state->kept[current_level].holds;
    } else {
        unpin(topic, pin);
    }
}

// Acquire, here and below: what `head` counts is in the ring. The read-modify-writes on the ring
// would do without; it costs nothing on x86, and one instruction on Arm.
inline uint32_t newest_number(const Topic& topic) {
    return topic.state->head.load(std::memory_order_acquire);
}

// Nothing was published yet. Only where `head` is 0, which it also is after 2^32 samples.
inline bool is_empty(const Topic& topic) {
    const RingEntry& last = topic.ring[topic.depth - 1U];
    return slot_of(last.word.load(std::memory_order_relaxed)) == kNoSlot;
}

// True if the reader has seen sample `seen`, which `head` does not count yet: an entry may be newer
// than `head` says, by one. A reader says 0 if it has seen none or the 2^32nd; there, the entry
// tells.
inline bool is_ahead(const Topic& topic, uint32_t seen, uint32_t head) {
    if (seen - head != 1) return false;
    if (seen != 0) return true;
    const uint64_t entry = topic.ring[topic.depth - 1U].word.load(std::memory_order_acquire);
    return slot_of(entry) != kNoSlot && static_cast<int32_t>(sequence_of(entry) - head) >= 0;
}

// Takes the newest sample, but none older than number `seen`, which the reader has seen already.
// False if there is none yet: then nothing is held. Wait-free.
inline bool take_latest(const Topic& topic, uint32_t seen, Pin& pin, bool /*marks*/ = true) {
    uint32_t head = newest_number(topic);
    if (is_ahead(topic, seen, head)) head = seen;
    Kept& kept = topic.state->kept[current_level];
    if (!kept.is_kept || kept.number != head) {
        if (head == 0 && is_empty(topic)) return false;
        if (kept.holds != 0) {  // by this job: it gets the newer one beside it
            pin.is_kept = false;
            pin_entry(topic, head - 1, pin);
            return true;
        }
        if (kept.is_kept) unpin(topic, kept);
        pin_entry(topic, head - 1, kept);
        kept.is_kept = true;
    }
    ++kept.holds;
    pin = kept;
    return true;
}

// The same for a reader that a sample has woken, so that there is one.
inline void take_woken(const Topic& topic, uint32_t seen, Pin& pin) {
    take_latest(topic, seen, pin);
}

// True if a sample after number `cursor` was published.
inline bool has_unread(const Topic& topic, uint32_t cursor) {
    const uint32_t head = newest_number(topic);
    return head != cursor && !is_ahead(topic, cursor, head);
}

// Takes the oldest sample after number `cursor`, moves `cursor` on to it and adds to `lost` what
// the ring no longer holds. False if there is none. Wait-free.
inline bool take_next(const Topic& topic, uint32_t& cursor, uint32_t& lost, Pin& pin,
                      bool /*marks*/ = true) {
    const uint32_t head = newest_number(topic);
    if (head == cursor || is_ahead(topic, cursor, head)) return false;
    uint32_t next = cursor;
    // Before the entry is taken: else a reader that was overtaken skips samples that are still
    // there.
    if (head - next > topic.depth) next = head - topic.depth;
    pin_entry(topic, next, pin);
    lost += pin.number - 1 - cursor;
    cursor = pin.number;
    return true;
}

// --- publishers ---

// A slot to build one sample in, until `commit`.
struct Loan {
    uint8_t slot = 0;
};

// Finds a slot that nobody reads. The compiler's slot count makes sure there is one. Acquire: the
// readers that are done have read.
inline Loan loan(const Topic& topic, bool /*keep*/) {
    const Lock lock(topic.mutex);  // else two publishers take one slot
    for (uint8_t slot = 0; slot < topic.slots; ++slot) {
        SlotState& user = topic.users[slot];
        const uint32_t done = user.done.load(std::memory_order_acquire);
        if (user.is_live || ((done - user.taken) & kReaderMask) != 0) continue;
        user.is_live = true;
        return {slot};
    }
    fail("topic: no free slot");
}

// Makes the sample the newest one, and returns its number. All of it under one lock: a sequence
// number drawn outside goes backwards, and `head` stored outside may end too low, so that the last
// sample is never seen.
inline uint32_t commit(const Topic& topic, Loan loaned, const std::byte* /*sample*/) {
    const Lock lock(topic.mutex);
    const uint32_t sequence = topic.state->head.load(std::memory_order_relaxed);
    std::atomic<uint64_t>& word = topic.ring[sequence & (topic.depth - 1U)].word;
    // Release: who takes the entry sees the sample. Acquire: who took the old one, and what it was
    // done with before; release alone may leave no free slot.
    const uint64_t old = word.exchange(entry_of(sequence, loaned.slot), std::memory_order_acq_rel);
    if (slot_of(old) != kNoSlot) {
        SlotState& user = topic.users[slot_of(old)];
        user.taken += readers_of(old);
        user.is_live = false;
    }
    // After the exchange: else a reader finds an old entry, or an empty one.
    topic.state->head.store(sequence + 1, std::memory_order_release);
    return sequence + 1;
}

// The thinned subscribers that are due, one bit each. Under the lock: two publishers would both
// pass.
inline uint32_t due_thinned(const Topic& topic, uint64_t timestamp_us) {
    uint32_t due = 0;
    const Lock lock(topic.mutex);
    for (unsigned i = 0; i < topic.thinned_count; ++i) {
        const Thinned& thinned = topic.thinned[i];
        if (timestamp_us < thinned.state->due_us) continue;
        const uint64_t late = timestamp_us - thinned.state->due_us;
        thinned.state->due_us += (late / thinned.interval_us + 1) * thinned.interval_us;
        thinned.state->fires.store(thinned.state->fires.load() + 1);
        due |= 1U << i;
    }
    return due;
}
// Wakes them behind the lock: waking is a system call, and another publisher may be waiting.
[[gnu::noinline]] inline void pend_thinned(const Topic& topic, uint64_t timestamp_us) {
    for (uint32_t due = due_thinned(topic, timestamp_us); due != 0; due &= due - 1) {
        set_pending(topic.thinned[std::countr_zero(due)].pend);
    }
}

// Wakes the subscribers of a topic whose newest sample is stamped `timestamp_us`.
inline void activate(const Topic& topic, uint64_t timestamp_us) {
    for (unsigned i = 0; i < topic.subscriber_count; ++i) set_pending(topic.subscribers[i]);
    if (topic.thinned_count != 0) pend_thinned(topic, timestamp_us);
}

}  // namespace stator
