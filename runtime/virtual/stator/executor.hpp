// The virtual-time executor as topics see it: pending bits, nesting, critical sections. Tasks stand
// in one list, most urgent level first and in planned order within it, so that a task's index says
// who may preempt whom: exactly the tasks before the running job's level.
#pragma once

#include <bit>
#include <cstdint>

namespace stator {

// A bit of the pending words.
struct Pend {
    uint32_t word;
    uint64_t mask;
};

struct Executor {
    uint64_t* pending = nullptr;
    unsigned words = 0;
    unsigned limit = ~0U;  // tasks of a lower index outrank the running job
    bool preemption_armed = false;
    uint64_t now_us = 0;
    const unsigned* level_begin = nullptr;  // [level]: index of its first task; 16 levels
};
extern Executor executor;

// Prints `what` and aborts: something that cannot happen has happened.
[[noreturn]] void fail(const char* what);
inline void require(bool condition, const char* what) {
    if (!condition) [[unlikely]] {
        fail(what);
    }
}

inline void clear_pending(const Pend& pend) {
    executor.pending[pend.word] &= ~pend.mask;
}
inline void set_pending(const Pend& pend) {
    executor.pending[pend.word] |= pend.mask;
}

// Index of the most urgent pending task; past the last task if none is pending.
inline unsigned first_pending() {
    for (unsigned word = 0; word < executor.words; ++word) {
        const uint64_t bits = executor.pending[word];
        if (bits != 0) return word * 64 + static_cast<unsigned>(std::countr_zero(bits));
    }
    return ~0U;
}

// Runs every pending task that outranks the running job, most urgent first.
void dispatch();
inline void preempt() {
    if (first_pending() < executor.limit) dispatch();
}

// Whether jobs can be preempted in the middle (`--times`): costs a test at every shared access, so
// that builds which do not need it leave it out.
#ifdef STATOR_PREEMPTION_POINTS
inline constexpr bool kHasPreemptionPoints = true;
#else
inline constexpr bool kHasPreemptionPoints = false;
#endif

// Lets time pass in the middle of a job, so that others preempt it.
void pass_preemption_point();
inline void preemption_point() {
    if constexpr (kHasPreemptionPoints) {
        if (executor.preemption_armed) [[unlikely]] {
            pass_preemption_point();
        }
    }
}

// Keeps the levels up to `ceiling` out, as BASEPRI does on the FMU; 0 keeps out nobody.
class Section {
  public:
    explicit Section(unsigned ceiling) : ceiling_(ceiling) {
        if (ceiling_ == 0) return;
        outer_ = executor.limit;
        const unsigned begin = executor.level_begin[ceiling_];
        executor.limit = begin < outer_ ? begin : outer_;
    }
    ~Section() {
        if (ceiling_ == 0) return;
        executor.limit = outer_;
        preempt();
    }
    Section(const Section&) = delete;
    Section& operator=(const Section&) = delete;

  private:
    unsigned ceiling_;
    unsigned outer_ = 0;
};

}  // namespace stator
