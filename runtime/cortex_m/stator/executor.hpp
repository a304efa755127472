// The NVIC as topics see it: a task is an interrupt vector, a level is a hardware priority, and
// pending a task is one store. Nothing here dispatches: the hardware does.
#pragma once

#include <cstdint>

#include "stator/registers.hpp"

namespace stator {

// A bit of the set-pending registers.
struct Pend {
    uint32_t word;
    uint32_t mask;
};

inline void set_pending(const Pend& pend) {
    nvic::set_pending(pend.word).write(pend.mask);
}
inline void clear_pending(const Pend& pend) {
    nvic::clear_pending(pend.word).write(pend.mask);
    barrier();  // what is pended from here on stays pended
}

// The hardware takes a more urgent vector by itself, within a few instructions of the store. No
// barrier: nothing in a topic rests on the instant (facts of one level are private to it).
inline void preempt() {}
inline void preemption_point() {}
inline constexpr bool kHasPreemptionPoints = false;

// Leaves a record with `what`, makes the board safe and resets: something that cannot happen has
// happened.
[[noreturn]] void fail(const char* what);
inline void require(bool condition, const char* what) {
    if (!condition) [[unlikely]] {
        fail(what);
    }
}

// Level 15 is hardware priority 1, level 1 is 15; priority 0 touches no topic. Four bits of eight.
constexpr uint32_t hardware_priority(unsigned level) {
    return (16U - level) << 4;
}

// Keeps the levels up to `ceiling`, which is at least 1, out by BASEPRI. PRIMASK is never used, so
// that hardware priority 0 always gets in.
class Section {
  public:
    [[gnu::always_inline]] explicit Section(unsigned ceiling) {
        asm volatile("mrs %0, basepri" : "=r"(outer_)::"memory");
        // BASEPRI_MAX only ever raises. ISB: without it, an instruction or two behind the write may
        // still be interrupted (DDI 0403E, B5.2.3).
        asm volatile("msr basepri_max, %0\n\tisb" ::"r"(hardware_priority(ceiling)) : "memory");
    }
    [[gnu::always_inline]] ~Section() { asm volatile("msr basepri, %0" ::"r"(outer_) : "memory"); }
    Section(const Section&) = delete;
    Section& operator=(const Section&) = delete;

  private:
    uint32_t outer_;
};

}  // namespace stator
