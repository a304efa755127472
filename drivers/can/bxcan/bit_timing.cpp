// Bit timing of bxCAN.
#include "bxcan_port.hpp"

namespace stator::drivers::can::bxcan {

// A bit is 1 + segment 1 (1 to 16) + segment 2 (1 to 8) quanta, sampled after segment 1. The most
// quanta first: they place the sample best. The controller may move an edge by all of segment 2, at
// most 4 quanta: at 1 Mbit/s by 3 of 14, which bears clocks that differ by more than 1 %, as the
// internal oscillator does (ISO 11898-1: the smaller of 3 / (20 * 14) and 3 / (2 * (13 * 14 - 3))
// for each of two nodes). Silent and loop-back mode, bits 31 and 30, stay off.
uint32_t bit_timing(uint32_t clock_hz, uint32_t bit_rate) {
    constexpr uint32_t kMaxPrescaler = 1024;
    for (uint32_t quanta = 20; quanta >= 8 && bit_rate != 0; --quanta) {
        if (clock_hz % (bit_rate * quanta) != 0) continue;
        const uint32_t prescaler = clock_hz / (bit_rate * quanta);
        if (prescaler == 0 || prescaler > kMaxPrescaler) continue;
        const uint32_t segment2 = (quanta + 2) / 5;
        const uint32_t segment1 = quanta - 1 - segment2;
        const uint32_t jump = segment2 < 4 ? segment2 : 4;
        return ((jump - 1) << 24) | ((segment2 - 1) << 20) | ((segment1 - 1) << 16) |
               (prescaler - 1);
    }
    return 0;
}

}  // namespace stator::drivers::can::bxcan
