// What a run that failed leaves behind for the next one, in memory that a reset does not clear.
// codegen/stator/live/fault_record.py reads the layout here: little-endian, no padding.
#pragma once

#include <array>
#include <cstdint>

namespace stator {

struct FaultRecord {
    enum class Cause : uint32_t { kNone, kFault, kAssertion, kWatchdog };

    Cause cause = Cause::kNone;
    uint32_t exception = 0;  // IPSR: 3 HardFault ... 6 UsageFault; from 16 on, a vector
    uint32_t exc_return = 0;
    uint32_t stack_pointer = 0;
    uint32_t status = 0;  // CFSR
    uint32_t hard_status = 0;
    uint32_t memory_address = 0;
    uint32_t bus_address = 0;
    uint32_t has_frame = 0;            // the stack could be read
    std::array<uint32_t, 8> frame{};   // r0 to r3, r12, lr, pc, xpsr of what was interrupted
    std::array<uint32_t, 8> saved{};   // r4 to r11 at the handler's entry
    std::array<uint32_t, 4> active{};  // vectors: the task of each level that was running
    uint32_t nested = 0;               // exception of a fault inside the fault, else 0
    uint32_t silent_task = 0;          // 1 + index of the task that showed no life; 0: none
    uint32_t resets = 0;               // in a row, within kResetWindow_us
    uint64_t uptime_us = 0;
    uint64_t window_us = 0;  // from the first of `resets` to this one
    uint32_t activation_count = 0;
    // The newest, where (count - 1) % 32 is the last: time in ticks modulo 2^24, and the task's
    // index.
    std::array<uint32_t, 32> activations{};
    std::array<char, 48> what{};        // of an assertion
    std::array<char, 16> graph_hash{};  // its first digits, in hexadecimal
    std::array<uint8_t, 20> build_id{};
};
static_assert(sizeof(FaultRecord) == 360);

// So many resets within this time end in safe mode.
inline constexpr uint32_t kMaxResets = 3;
inline constexpr uint64_t kResetWindow_us = 10'000'000;

// The record of the run before; cause kNone if it left none.
extern FaultRecord last_fault_record;
inline bool is_safe_mode() {
    return last_fault_record.resets >= kMaxResets;
}

// Reads what the run before left into `last_fault_record`, once. Context: before the graph starts.
void take_fault_record();

}  // namespace stator
