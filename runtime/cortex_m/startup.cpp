// From reset to the idle loop.
#include <cstddef>

#include "stator/cortex_m.hpp"

// Laid out by the generated linker script.
extern "C" {
extern uint32_t stator_vectors[];
extern const uint32_t stator_data_image[];
extern uint32_t stator_data_begin[];
extern uint32_t stator_data_end[];
extern uint32_t stator_bss_begin[];
extern uint32_t stator_bss_end[];
extern void (*const stator_init_begin[])();
extern void (*const stator_init_end[])();
}

namespace stator {

namespace {

// No lazy saving: docs/decisions/0007-no-lazy-fpu-saving.md.
void enable_fpu() {
    scb::kCoprocessors.set(scb::kFpuFullAccess);
    fpu::kContextControl.set(fpu::kAutomaticSave);
    fpu::kContextControl.clear(fpu::kLazySave);
    barrier();
}

void fill_memory() {
    const uint32_t* from = stator_data_image;
    for (uint32_t* to = stator_data_begin; to != stator_data_end;) *to++ = *from++;
    for (uint32_t* to = stator_bss_begin; to != stator_bss_end;) *to++ = 0;
}

void construct() {
    for (auto* init = stator_init_begin; init != stator_init_end; ++init) (*init)();
}

void enable_faults() {
    scb::kVectorTable.write(reinterpret_cast<uint32_t>(stator_vectors));
    scb::kConfiguration.set(scb::kDivideByZeroFaults);
    scb::kHandlers.set(scb::kFaultHandlers);
    barrier();
    guard_memory();
}

void enable_vectors() {
    for (unsigned i = 0; i < program.interrupt_count; ++i) {
        const Interrupt& row = program.interrupts[i];
        nvic::priority(row.vector) = static_cast<uint8_t>(hardware_priority(row.level));
    }
    scb::kSystickPriority.write(hardware_priority(program.timer_level)
                                << scb::kSystickPriorityShift);
    for (unsigned i = 0; i < program.interrupt_count; ++i) {
        const Interrupt& row = program.interrupts[i];
        nvic::set_enable(row.vector / 32U).write(1U << row.vector % 32U);
    }
}

// Not inlined: the compiler takes the block for a few bytes, and would branch too far around it.
[[gnu::noinline]] void rest() {
#ifdef STATOR_SLEEP
    asm volatile("wfi" ::: "memory");
#else
    // An emulator runs a long block at once, and a short loop slowly.
    asm volatile(".rept 128\n\tnop\n\t.endr" ::: "memory");
#endif
}

// The monitor runs after each of SysTick, which comes at least every 50 ms.
[[noreturn]] void idle() {
    for (uint32_t seen = 0;;) {
        const uint32_t wakes = release_count.load();
        if (wakes != seen) monitor();
        seen = wakes;
        rest();
    }
}

// After too many resets the graph does not start: the motors stay in their defined state.
[[noreturn]] void stay_safe() {
    board::make_safe();
    stator_release();
    idle();
}

[[noreturn, gnu::noinline]] void run() {
    fill_memory();
    enable_faults();
    construct();
    take_fault_record();
    if (last_fault_record.cause != FaultRecord::Cause::kNone) board::report(last_fault_record);
    board::prepare();
    if (is_safe_mode()) stay_safe();
    program.start();
    enable_vectors();
    board::start();
    stator_release();  // what is due at the start; arms SysTick
    idle();
}

}  // namespace

// The FPU comes first: the compiler may use its registers anywhere.
extern "C" void stator_reset() {
    enable_fpu();
    run();
}

}  // namespace stator
