// What counts instructions, and the places that it is read at: TIM4, which QEMU counts at 1 GHz,
// with -icount shift=0 once an instruction.
#pragma once

#include <array>
#include <cstdint>

#include "stator/registers.hpp"
#include "stator/topic.hpp"

namespace stator::counting {

inline constexpr Register kControl(0x40000800);
inline constexpr Register kCount(0x40000824);
inline constexpr unsigned kByHandVector = 29;  // vector of TIM3
inline constexpr unsigned kEntryVector = 30;   // vector of TIM4
inline constexpr unsigned kProbeVector = 6;    // vector of EXTI0

// The same two instructions wherever they stand, so that what is counted between two of them is
// exactly what else runs there.
[[gnu::always_inline]] inline uint32_t read_exactly() {
    uint32_t count = 0;
    asm volatile("mov.w %0, #0x40000000\n\tldr.w %0, [%0, #0x824]" : "=r"(count));
    return count;
}

enum class Place : uint8_t { kStep, kDriver, kByHand, kEntry };
inline volatile uint32_t reached[4] = {};

// The first thing that a node does, with its sample at hand.
[[gnu::always_inline]] inline void reach(Place place, const void* sample) {
    asm volatile("" ::"r"(sample));
    reached[static_cast<unsigned>(place)] = kCount.read();
    asm volatile("" ::: "memory");  // nothing of what follows the step is counted
}

// The same of a node without a sample.
[[gnu::always_inline]] inline void reach_exactly(Place place) {
    reached[static_cast<unsigned>(place)] = read_exactly();
}

// A topic of 32 bytes as one would write it by hand: two slots, one reader above the publisher.
struct WrittenByHand {
    struct Sample {
        uint64_t timestamp;
        std::array<uint32_t, 6> values;
    };
    Shared<uint32_t> newest;
    std::array<Sample, 2> slots;
};
inline WrittenByHand written_by_hand{};

}  // namespace stator::counting
