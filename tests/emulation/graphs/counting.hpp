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
inline constexpr unsigned kEmptyVector = 30;   // vector of TIM4
inline constexpr unsigned kProbeVector = 6;    // vector of EXTI0

enum class Place : uint8_t { kStep, kDriver, kByHand, kEmpty };
inline volatile uint32_t reached[4] = {};

// The first thing that a node does, with its sample at hand.
[[gnu::always_inline]] inline void reach(Place place, const void* sample) {
    asm volatile("" ::"r"(sample));
    reached[static_cast<unsigned>(place)] = kCount.read();
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
