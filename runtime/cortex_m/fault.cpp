// Faults, vectors that nobody uses, and what cannot happen: all end in the board's safe state.
#include <array>
#include <cstddef>

#include "stator/cortex_m.hpp"

extern "C" {
extern uint32_t stator_stack_begin[];
extern uint32_t stator_stack_end[];
// Of its own, as the fault may be that the stack is full. Only assembly names these two.
[[gnu::used, gnu::externally_visible]] alignas(8) std::array<uint32_t, 128> stator_fault_stack;
[[gnu::used, gnu::externally_visible, noreturn]] void stator_on_fault(const uint32_t* frame);
}

namespace stator {

namespace {

constexpr size_t kFrameWords = 8;
constexpr size_t kProgramCounter = 6;

uint32_t active_exception() {
    uint32_t number = 0;
    asm volatile("mrs %0, ipsr" : "=r"(number));
    return number;
}

}  // namespace

void fail(const char* what) {
    board::halt(what);
}

// Entered with the stack pointer at the exception frame, if there was room for one.
[[gnu::naked]] void stator_fault() {
    asm volatile(
        "mrs r0, msp\n\t"
        "ldr r1, =stator_fault_stack + 512\n\t"
        "msr msp, r1\n\t"
        "b stator_on_fault\n\t"
        ".ltorg");
}

}  // namespace stator

void stator_on_fault(const uint32_t* frame) {
    using namespace stator;
    const bool readable = frame >= stator_stack_begin && frame + kFrameWords <= stator_stack_end;
    board::halt(Fault{.exception = active_exception(),
                      .status = scb::kFaultStatus.read(),
                      .hard_status = scb::kHardFaultStatus.read(),
                      .memory_address = scb::kMemoryFaultAddress.read(),
                      .bus_address = scb::kBusFaultAddress.read(),
                      .program_counter = readable ? frame[kProgramCounter] : 0});
}
