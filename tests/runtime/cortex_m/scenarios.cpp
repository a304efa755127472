// The bare-metal executor without a graph: each scenario prints what happened; SCENARIO chooses
// one.
#include "semihosting.hpp"
#include "stator/cortex_m.hpp"
#include "timers.hpp"

extern "C" uint32_t stator_stack_end[];

namespace stator {

namespace {

using semihosting::print;

// Vectors 0 to 3, by their levels.
constexpr Interrupt kInterrupts[] = {{0, 5}, {1, 3}, {2, 3}, {3, 1}};
constexpr Pend kHigh{0, 1U << 0};
constexpr Pend kMiddle{0, 1U << 1};
constexpr Pend kOther{0, 1U << 2};
constexpr Pend kLow{0, 1U << 3};

TimerState millisecond;
TimerState slower;
constexpr Timer kTimers[] = {{&millisecond, 1000, 0, kMiddle}, {&slower, 2500, 100, kOther}};

uint32_t clock_offset = 0;
bool is_unsafe = false;  // the board faults when it is to make the motors safe
void (*in_low)() = nullptr;
void (*in_middle)() = [] { print("middle "); };
void (*in_other)() = [] { print("other "); };

void high() {
    print("high ");
}
void middle() {
    in_middle();
}
void other() {
    in_other();
}
void low() {
    print("low( ");
    in_low();
    print(")low");
    semihosting::exit(0);
}

[[maybe_unused]] void run_low(void (*job)()) {
    in_low = job;
    set_pending(kLow);
}

// --- scenarios ---

[[maybe_unused]] void order() {
    run_low([] { set_pending({0, kHigh.mask | kMiddle.mask | kOther.mask}); });
}

[[maybe_unused]] void section() {
    run_low([] {
        const Section section(3);
        set_pending(kMiddle);
        set_pending(kHigh);
        print("held ");
    });
}

[[maybe_unused]] void nested_section() {
    run_low([] {
        const Section outer(5);
        {
            const Section inner(3);
            set_pending(kHigh);
        }
        print("held ");
    });
}

[[maybe_unused]] void cleared() {
    run_low([] {
        const Section section(5);
        set_pending(kHigh);
        clear_pending(kHigh);
        print("held ");
    });
}

// Across the wrap of the 32-bit timer, and of its half.
[[maybe_unused]] void clock() {
    in_middle = [] {};
    in_other = [] {};
    run_low([] {
        constexpr uint32_t kStarts[] = {0xFFFFFF00U, 0x7FFFFF00U};
        for (const uint32_t start : kStarts) {
            const uint32_t jump = start - board::timer_us();
            // Otherwise the releases of up to 71 minutes would be made one by one.
            for (const Timer& timer : kTimers) timer.state->released_us = clock_us() + jump;
            clock_offset += jump;
            stator_release();
            const uint64_t begin = clock_us();
            uint64_t last = begin;
            while (last - begin < 1000) {
                const uint64_t now = clock_us();
                if (now < last || now - last > 10) print("jumped ");
                last = now;
            }
        }
        print("ran ");
    });
}

[[maybe_unused]] void releases() {
    in_other = [] {};
    in_middle = [] {
        const uint32_t fires = millisecond.fires.load();
        const uint64_t nominal_us =
            nominal_time_us(TimerState{.fires = {}, .served_us = fires * 1000ULL}, 1000, 0);
        const bool is_first = fires == 1;  // due at 0, before the program had started
        if (!is_first && clock_us() - nominal_us > 2) print("late ");
        if (fires != 51) return;
        print(slower.fires.load());
        semihosting::exit(0);
    };
}

[[maybe_unused]] void unmapped() {
    run_low([] { Register(0x60000000).read(); });
}
[[maybe_unused]] void divide() {
    run_low([] {
        volatile int one = 1;
        volatile int zero = 0;
        one = one / zero;
    });
}
[[maybe_unused]] void nested() {
    is_unsafe = true;
    divide();
}
[[maybe_unused]] void undefined() {
    run_low([] { asm volatile("udf #0"); });
}
[[maybe_unused]] void nobody() {
    nvic::set_enable(0).write(1U << 20);
    set_pending({0, 1U << 20});
}
[[maybe_unused]] void impossible() {
    run_low([] { require(in_low == nullptr, "this cannot be"); });
}

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Winfinite-recursion"
[[gnu::noinline]] uint32_t recurse(volatile uint32_t* before) {
    volatile uint32_t here[16] = {*before};
    return recurse(here) + here[0];
}
#pragma GCC diagnostic pop
[[maybe_unused]] void overflow() {
    run_low([] {
        volatile uint32_t start = 0;
        recurse(&start);
    });
}

struct VectorTable {
    uint32_t* stack_end;
    void (*handlers[15 + 29])();
};

#define FAULT stator_fault
#define FAULT_8 FAULT, FAULT, FAULT, FAULT, FAULT, FAULT, FAULT, FAULT

}  // namespace

extern const Program program;
constinit const Program program{.tasks = nullptr,
                                .task_count = 0,
                                .timers = kTimers,
                                .timer_count = 2,
                                .timer_level = 3,
                                .interrupts = kInterrupts,
                                .interrupt_count = 4,
                                .watched = nullptr,
                                .watched_count = 0,
                                .topics = nullptr,
                                .topic_count = 0,
                                .core_clock_hz = 168'000'000,
                                .board = "",
                                .graph = "scenarios",
                                .graph_hash = "0123456789abcdef",
                                .start = [] {}};

extern "C" {
extern const VectorTable stator_vectors;
[[gnu::section(".vectors"), gnu::used]] constinit const VectorTable stator_vectors{
    stator_stack_end,
    {stator_reset, FAULT_8, FAULT, FAULT, FAULT, FAULT, FAULT, stator_release, high, middle, other,
     low, FAULT_8, FAULT_8, FAULT_8, FAULT}};
}

namespace board {

uint32_t timer_us() {
    return Clock().us() + clock_offset;
}
void prepare() {
    Clock().start();
}
void start() {
    SCENARIO();
}
extern const TickSource kTickSource{1'000'000, 0, 1};
uint32_t ticks() {
    return Clock().us();
}
void make_safe() {
    if (is_unsafe) Register(0x60000000).read();
}
void kick_watchdog() {}
bool watchdog_was_kicked() {
    return true;
}
// In the next start.
void report(const FaultRecord& record) {
    if (record.cause == FaultRecord::Cause::kAssertion) {
        print(record.what.data());
        semihosting::exit(2);
    }
    print("exception ");
    print(record.exception);
    print(" status ");
    print(record.status);
    print(record.has_frame == 0 ? " no stack" : "");
    if (record.nested != 0) {
        print(" nested ");
        print(record.nested);
    }
    semihosting::exit(3);
}

}  // namespace board

}  // namespace stator
