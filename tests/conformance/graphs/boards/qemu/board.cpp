// Prints the trace on the emulator's console, and ends the program.
#include "board.hpp"

#include "../../../../../boards/qemu_f405/semihosting.hpp"
#include "../../../../../boards/qemu_f405/timers.hpp"
#include "stator/cortex_m.hpp"

namespace stator {

void trace::write(const char* line, uint64_t) {
    semihosting::print(line);
}

namespace board {

namespace {

constexpr uint32_t kPressedVector = 6;  // EXTI0
bool is_pressed = false;

}  // namespace

drivers::button::test::ButtonTest::Device finger0{.press = [] {
    is_pressed = true;
    set_pending({kPressedVector / 32, 1U << kPressedVector % 32});
}};
drivers::button::test::ButtonTest::Device button0;

uint32_t timer_us() {
    return Clock().us();
}
void prepare() {
    Clock().start();
}
void start() {
    kStepTimer.start();
}

bool take_button0_pressed();
bool take_button0_pressed() {
    const bool was = is_pressed;
    is_pressed = false;
    return was;
}

void tim2_interrupt();
void tim2_interrupt() {
    kStepTimer.acknowledge();
    static uint32_t time_ms = 0;
    if (++time_ms * 1000 >= trace::kEnd_us) semihosting::exit(0);
}

extern const TickSource kTickSource{1'000'000, 1, 1};
uint32_t ticks() {
    return Clock().us();
}
void make_safe() {}
void kick_watchdog() {}
void report(const FaultRecord& record) {
    semihosting::print("stator: failed at ");
    semihosting::print(record.frame[6]);
    semihosting::print(record.what.data());
    semihosting::exit(1);
}

}  // namespace board

}  // namespace stator
