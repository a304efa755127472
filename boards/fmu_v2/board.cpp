// Starts the Pixhawk FMU: clocks, supplies, pins, the clock of the graph, the CAN controller, the
// watchdog. It builds, links and passes every static check; no hardware has run it.
#include "board.hpp"

#include "pins.hpp"
#include "stator/cortex_m.hpp"
#include "stm32f4/clock_tree.hpp"
#include "stm32f4/timer.hpp"
#include "stm32f4/watchdog.hpp"

namespace stator::board {

namespace {

namespace bxcan = drivers::can::bxcan;

constexpr uint32_t kCrystal_mhz = 24;
constexpr uint32_t kWatchdog_ms = 500;  // nominal: 340 to 940, ten turns of the monitor and more
constexpr stm32f4::MicrosecondTimer kTimer;
constexpr stm32f4::Watchdog kWatchdog;

// No part is selected while the supplies come up.
void start_pins() {
    for (const stm32f4::Pin& select : pins::kSelects) select.make_output(true);
    pins::kAmberLed.make_output(true);
    pins::kSensorSupply.make_output(true);
    pins::kPeripheralSupplyOff.make_output(false);
}

// RM0090, 2.3 and 6.3.13. Until the driver starts it, the controller sleeps and sends nothing but
// recessive bits (32.4).
constexpr uint32_t kCan1 = 0x40006400;
constexpr uint32_t kCan1Clock = 1U << 25;

void start_can() {
    stm32f4::rcc::kApb1Enable.set(kCan1Clock);
    pins::kCan1Receive.make_alternate(pins::kCanFunction);
    pins::kCan1Send.make_alternate(pins::kCanFunction);
}

bool take_can1(uint32_t interrupts) {
    return bxcan::take_line(bxcan::Memory{kCan1}, interrupts);
}

}  // namespace

drivers::can::bxcan::CanBxcan::Device can1{.base = kCan1, .clock_hz = stm32f4::kApb1Clock_hz, .bit_rate = 1'000'000};
drivers::system::board::SystemBoard::Device system0{.restart = restart};

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
    start_can();
}

// If the hardware does not take the time, the watchdog runs with its longest one.
void start() {
    static_cast<void>(kWatchdog.start(kWatchdog_ms));
}

void kick_watchdog() {
    kWatchdog.kick();
}

// Of the lines' dispatchers.
bool take_can1_received();
bool take_can1_received() {
    return take_can1(bxcan::kFifoNotEmpty);
}
bool take_can1_sent();
bool take_can1_sent() {
    return take_can1(bxcan::kMailboxEmpty);
}
bool take_can1_changed();
bool take_can1_changed() {
    return take_can1(bxcan::kErrors);
}

// The link answers requests for the record.
void report(const FaultRecord&) {}

}  // namespace stator::board
