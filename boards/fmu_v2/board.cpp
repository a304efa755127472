// Starts the Pixhawk FMU: clocks, supplies, pins, the clock of the graph, the watchdog. It builds,
// links and passes every static check; no hardware has run it.
#include "board.hpp"

#include "pins.hpp"
#include "stator/cortex_m.hpp"
#include "stm32f4/clock_tree.hpp"
#include "stm32f4/timer.hpp"
#include "stm32f4/watchdog.hpp"

namespace stator::board {

namespace {

constexpr uint32_t kCrystal_mhz = 24;
constexpr uint32_t kWatchdog_ms = 500;  // nominal: 340 to 940, ten turns of the monitor and more
constexpr stm32f4::MicrosecondTimer kTimer;
constexpr stm32f4::Watchdog kWatchdog;

// Nobody is selected while the supplies come up.
void start_pins() {
    for (const stm32f4::Pin& select : pins::kSelects) select.make_output(true);
    pins::kAmberLed.make_output(true);
    pins::kSensorSupply.make_output(true);
    pins::kPeripheralSupplyOff.make_output(false);
}

}  // namespace

// Low: no pulse. A speed controller that sees none stops its motor.
void make_safe() {
    for (const stm32f4::Pin& output : pins::kMotorOutputs) output.make_output(false);
}

uint32_t timer_us() {
    return kTimer.us();
}

extern const TickSource kTickSource{168'000'000, 0, 1};
uint32_t ticks() {
    return cycles::kCount.read();
}

void prepare() {
    make_safe();
    cycles::kDebugControl.set(cycles::kTrace);
    cycles::kControl.set(cycles::kEnable);
    require(stm32f4::start_clocks(kCrystal_mhz) != stm32f4::ClockSource::kNone, "no clock");
    kTimer.start();
    start_pins();
}

// If the hardware does not take the time, the watchdog runs with its longest one.
void start() {
    static_cast<void>(kWatchdog.start(kWatchdog_ms));
}

void kick_watchdog() {
    kWatchdog.kick();
}

// Who asks on the link is told.
void report(const FaultRecord&) {}

}  // namespace stator::board
