// Presses the switches at their times, and ends the program.
#include "board.hpp"

#include "../../../../../boards/qemu_f405/semihosting.hpp"
#include "../../../../../boards/qemu_f405/timers.hpp"
#include "stator/cortex_m.hpp"

namespace stator::board {

drivers::contact::test::ContactTest::Device switch0;
drivers::contact::test::ContactTest::Device switch1;

namespace {

constexpr uint32_t kSharedVector = 23;  // EXTI9_5

enum Line : uint32_t { kUp0 = 1, kDown0 = 2, kUp1 = 4 };
uint32_t raised = 0;

bool take(Line line) {
    const bool was = (raised & line) != 0;
    raised &= ~line;
    return was;
}
void raise(uint32_t lines) {
    raised |= lines;
    set_pending({kSharedVector / 32, 1U << kSharedVector % 32});
}

}  // namespace

uint32_t timer_us() {
    return Clock().us();
}
void prepare() {
    Clock().start();
}
void start() {
    kStepTimer.start();
}

bool take_switch0_up();
bool take_switch0_up() {
    return take(kUp0);
}
bool take_switch0_down();
bool take_switch0_down() {
    return take(kDown0);
}
bool take_switch1_up();
bool take_switch1_up() {
    return take(kUp1);
}

void tim2_interrupt();
void tim2_interrupt() {
    kStepTimer.acknowledge();
    static uint32_t time_ms = 0;
    ++time_ms;
    semihosting::print(" ");
    if (time_ms == 2) raise(kUp0);
    if (time_ms == 3) raise(kUp0 | kDown0);
    if (time_ms == 6) raise(kUp1);
    if (time_ms == 10) raise(kUp0 | kUp1);
    if (time_ms == 17) semihosting::exit(0);
}

extern const TickSource kTickSource{1'000'000'000, 1, 1};
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

}  // namespace stator::board
