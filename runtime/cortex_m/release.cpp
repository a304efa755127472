// Time and periodic releases. Tickless: SysTick is armed for the next release, counts its fires and
// pends its task; the deadlines are absolute, so that nothing drifts.
#include "stator/cortex_m.hpp"

namespace stator {

namespace {

// The longest SysTick may sleep: 2^24 ticks last 99 ms at 168 MHz.
constexpr uint64_t kLongestSleep_us = 50'000;

// Half periods of the 32-bit timer that have passed. Its lowest bit repeats the timer's highest
// one, so that a reader sees whether this word lags behind the timer, whatever preempts it.
Shared<uint32_t> half_periods;

}  // namespace

Shared<uint32_t> release_count;

namespace {

constexpr uint32_t corrected(uint32_t known, uint32_t timer) {
    return known + ((known ^ (timer >> 31)) & 1U);
}

// Returns the earliest release after `now_us`.
uint64_t release_due(uint64_t now_us) {
    uint64_t next_us = now_us + kLongestSleep_us;
    for (unsigned i = 0; i < program.timer_count; ++i) {
        const Timer& timer = program.timers[i];
        while (next_release_us(timer) <= now_us) {
            release(timer);
        }
        const uint64_t release_us = next_release_us(timer);
        if (release_us < next_us) next_us = release_us;
    }
    return next_us;
}

void arm(uint64_t sleep_us) {
    const uint32_t ticks_per_us = program.core_clock_hz / 1'000'000U;
    systick::kReload.write(static_cast<uint32_t>(sleep_us) * ticks_per_us);
    systick::kCurrent.write(0);
    systick::kControl.write(systick::kEnable | systick::kInterrupt | systick::kCoreClock);
}

}  // namespace

uint64_t clock_us() {
    // In this order: a timer value newer than the word is what the word's lowest bit corrects.
    const uint32_t known = half_periods.load();
    const uint32_t timer = board::timer_us();
    return (uint64_t{corrected(known, timer)} << 31) | (timer & 0x7FFFFFFFU);
}

bool note_line(LineState& line, uint32_t min_interarrival_us) {
    if (!accept_line(line, clock_us(), min_interarrival_us)) return false;
    line.fires.store(line.fires.load() + 1);
    return true;
}

// The handler of SysTick; called once before it runs.
void stator_release() {
    release_count.store(release_count.load() + 1);
    half_periods.store(corrected(half_periods.load(), board::timer_us()));
    uint64_t now_us = clock_us();
    uint64_t next_us = release_due(now_us);
    while ((now_us = clock_us()) >= next_us) next_us = release_due(now_us);
    arm(next_us - now_us);
}

}  // namespace stator
