// The end of a run: faults, vectors that nobody uses, the watchdog, what cannot happen, and a
// restart that was requested. All put the motors into their defined state and reset, and all
// but the last leave a record.
#include <cstddef>
#include <cstring>

#include "stator/cortex_m.hpp"
#include "stator/kept_record.hpp"

extern "C" {
extern uint32_t stator_stack_begin[];
extern uint32_t stator_stack_end[];
// Of its own, as the fault may be that the stack is full. Only assembly names these.
[[gnu::used, gnu::externally_visible]] alignas(8) std::array<uint32_t, 256> stator_fault_stack;
[[gnu::used, gnu::externally_visible, noreturn]] void stator_on_fault(const uint32_t* frame,
                                                                      uint32_t exc_return,
                                                                      const uint32_t* saved);
}

namespace stator {

namespace {

bool is_recording = false;

uint32_t active_exception() {
    uint32_t number = 0;
    asm volatile("mrs %0, ipsr" : "=r"(number));
    return number;
}

[[noreturn]] void reset() {
    scb::kResetControl.write(scb::kResetRequest);
    while (true) barrier();
}

// A fault inside the fault: only what is certain.
[[noreturn]] void end_nested() {
    stator_kept_record.record.nested = active_exception();
    seal(stator_kept_record);
    reset();
}

}  // namespace

void add_registers(FaultRecord& record, const uint32_t* frame) {
    record.exception = active_exception();
    record.stack_pointer = reinterpret_cast<uint32_t>(frame);
    record.status = scb::kFaultStatus.read();
    record.hard_status = scb::kHardFaultStatus.read();
    record.memory_address = scb::kMemoryFaultAddress.read();
    record.bus_address = scb::kBusFaultAddress.read();
    for (uint32_t word = 0; word < record.active.size(); ++word) {
        record.active[word] = nvic::active(word).read();
    }
    if (frame < stator_stack_begin || frame + record.frame.size() > stator_stack_end) return;
    record.has_frame = 1;
    std::memcpy(record.frame.data(), frame, sizeof record.frame);
}

// The record stands before anything else is tried, as that may fault.
void end_run(FaultRecord& record) {
    add_run(record);
    seal(stator_kept_record);
    board::make_safe();
    reset();
}

void restart() {
    board::make_safe();
    reset();
}

FaultRecord& begin_fault_record(FaultRecord::Cause cause) {
    if (is_recording) end_nested();
    is_recording = true;
    stator_kept_record.record = FaultRecord{};
    stator_kept_record.record.cause = cause;
    return stator_kept_record.record;
}

void fail(const char* what) {
    FaultRecord& record = begin_fault_record(FaultRecord::Cause::kAssertion);
    add_registers(record, nullptr);
    record.frame[6] = reinterpret_cast<uint32_t>(__builtin_return_address(0));
    std::strncpy(record.what.data(), what, record.what.size() - 1);
    end_run(record);
}

// Entered with the stack pointer at the exception frame, if there was room for one.
[[gnu::naked]] void stator_fault() {
    asm volatile(
        "mrs r0, msp\n\t"
        "mov r1, lr\n\t"
        "ldr r2, =stator_fault_stack + 1024\n\t"
        "msr msp, r2\n\t"
        "push {r4-r11}\n\t"
        "mov r2, sp\n\t"
        "b stator_on_fault\n\t"
        ".ltorg");
}

}  // namespace stator

void stator_on_fault(const uint32_t* frame, uint32_t exc_return, const uint32_t* saved) {
    using namespace stator;
    FaultRecord& record = begin_fault_record(FaultRecord::Cause::kFault);
    record.exc_return = exc_return;
    std::memcpy(record.saved.data(), saved, sizeof record.saved);
    add_registers(record, frame);
    end_run(record);
}
