// A timer as the watchdog, or as the warning before it.
#include "stator/cortex_m.hpp"
#include "stator/kept_record.hpp"

extern "C" {
// Only assembly names it.
[[gnu::used, gnu::externally_visible]] void stator_on_watchdog_timer(const uint32_t* frame,
                                                                     uint32_t exc_return);
}

namespace stator {

// Entered with the stack pointer at the exception frame of what does not end.
[[gnu::naked]] void stator_watchdog_timer() {
    asm volatile(
        "mrs r0, msp\n\t"
        "mov r1, lr\n\t"
        "b stator_on_watchdog_timer");
}

}  // namespace stator

void stator_on_watchdog_timer(const uint32_t* frame, uint32_t exc_return) {
    using namespace stator;
    if (board::watchdog_was_kicked()) return;
    FaultRecord& record = begin_fault_record(FaultRecord::Cause::kWatchdog);
    record.exc_return = exc_return;
    add_registers(record, frame);
    end_run(record);
}
