// POSIX threads as topics see them: a level is a thread, a task is a bit of its level's pending
// word, and that word is also the futex on which the level sleeps.
#pragma once

#include <atomic>
#include <cstdint>

namespace stator {

// A bit of a level's pending word.
struct Pend {
    uint32_t word;  // place of the level, the most urgent is 0
    uint32_t mask;
};

inline constexpr unsigned kMaxLevels = 15;
inline constexpr unsigned kMaxTasksOfLevel = 30;
inline constexpr uint32_t kTaskBits = (1U << kMaxTasksOfLevel) - 1;
// The level runs: a thread that pends it need not wake it. A word of 0 means that it sleeps, or is
// about to, and that the next one to set a bit wakes it.
inline constexpr uint32_t kAwakeBit = 1U << 30;
inline constexpr uint32_t kStopBit = 1U << 31;

// On a cache line of its own, as every publisher writes it.
struct alignas(64) PendingWord {
    std::atomic<uint32_t> bits{0};
};
extern PendingWord pending_words[kMaxLevels];

// Place of the level that runs in this thread; kMaxLevels elsewhere.
extern constinit thread_local unsigned current_level;

// A system call: wakes the thread that sleeps on the word.
void wake_level(uint32_t word);

// Any thread. Release: what was published before is seen by the level that clears the bit, as all
// changes of the word are read-modify-writes and so belong to one release sequence. Relaxed loses
// samples: the level would run, find nothing and sleep.
inline void set_pending(const Pend& pend) {
    std::atomic<uint32_t>& bits = pending_words[pend.word].bits;
    if (bits.fetch_or(pend.mask, std::memory_order_release) == 0) wake_level(pend.word);
}
// Nothing: only the level itself clears its bits. A task that was switched off sees so in its
// wrapper, after its bit was cleared.
inline void clear_pending(const Pend&) {}

// More urgent levels run by themselves, on other processors or by the scheduler.
inline void preempt() {}
inline void preemption_point() {}
inline constexpr bool kHasPreemptionPoints = false;

// Prints `what` and aborts: something that cannot happen has happened.
[[noreturn]] void fail(const char* what);
inline void require(bool condition, const char* what) {
    if (!condition) [[unlikely]] {
        fail(what);
    }
}

}  // namespace stator
