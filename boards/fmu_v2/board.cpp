// Starts the Pixhawk FMU: clocks, supplies, pins, the clock of the graph, the watchdog. It builds,
// links and passes every static check; no hardware has run it.
#include "board.hpp"

#include "pins.hpp"
#include "stator/cortex_m.hpp"
#include "stm32f4/clock_tree.hpp"
#include "stm32f4/timer.hpp"

namespace stator::board {

namespace {

constexpr uint32_t kCrystal_mhz = 24;
constexpr stm32f4::MicrosecondTimer kTimer;

// Low: no pulse. A speed controller that sees none stops its motor.
void make_safe() {
    for (const stm32f4::Pin& output : pins::kMotorOutputs) output.make_output(false);
}

// Nobody is selected while the supplies come up.
void start_pins() {
    for (const stm32f4::Pin& select : pins::kSelects) select.make_output(true);
    pins::kAmberLed.make_output(true);
    pins::kSensorSupply.make_output(true);
    pins::kPeripheralSupplyOff.make_output(false);
}

[[noreturn]] void stop() {
    make_safe();
    pins::kAmberLed.make_output(false);
    while (true) {
    }
}

}  // namespace

uint32_t timer_us() {
    return kTimer.us();
}

void prepare() {
    make_safe();
    require(stm32f4::start_clocks(kCrystal_mhz) != stm32f4::ClockSource::kNone, "no clock");
    kTimer.start();
    start_pins();
}

void start() {}

void halt(const char*) {
    stop();
}

void halt(const Fault&) {
    stop();
}

}  // namespace stator::board
