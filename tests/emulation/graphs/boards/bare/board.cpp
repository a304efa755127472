// The board of programs that run in the emulator by themselves.
#include "../../../../../boards/qemu_f405/semihosting.hpp"
#include "../../../../../boards/qemu_f405/timers.hpp"
#include "../../counting.hpp"
#include "devices.hpp"
#include "stator/cortex_m.hpp"

namespace stator::board {

uint32_t timer_us() {
    return Clock().us();
}
void prepare() {
    Clock().start();
    counting::kControl.write(1);
}
void start() {
    for (const unsigned vector : {counting::kByHandVector, counting::kEntryVector}) {
        nvic::priority(vector) = static_cast<uint8_t>(hardware_priority(5));
        nvic::set_enable(vector / 32).write(1U << vector % 32);
    }
}

// Lines are raised by software, so that there is nothing to acknowledge.
bool take_probe0_raised();
bool take_probe0_raised() {
    return true;
}

// What a person would write for one topic with one reader above its publisher.
void tim3_interrupt();
void tim3_interrupt() {
    const counting::WrittenByHand& topic = counting::written_by_hand;
    counting::reach(counting::Place::kByHand, &topic.slots[topic.newest.load()]);
}
void tim4_interrupt();
// Its first instructions are the reading: so this is when a handler is entered.
[[gnu::naked]] void tim4_interrupt() {
    asm volatile(
        "mov.w r0, #0x40000000\n\tldr.w r0, [r0, #0x824]\n\t"
        "ldr r1, =%c0\n\tstr r0, [r1, %1]\n\tbx lr\n\t.ltorg" ::"i"(&counting::reached),
        "i"(sizeof(uint32_t) * static_cast<unsigned>(counting::Place::kEntry)));
}

extern const TickSource kTickSource{1'000'000'000, 1, 1};
uint32_t ticks() {
    return counting::kCount.read();
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
