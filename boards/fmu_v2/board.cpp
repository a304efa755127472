// Starts the Pixhawk FMU: clocks, supplies, pins, the clock of the graph, the CAN controller, the
// serial lines, the watchdog. It builds, links and passes every static check; no hardware has run
// it.
#include <array>
#include <span>

#include "devices.hpp"
#include "lines.hpp"
#include "pins.hpp"
#include "stator/cortex_m.hpp"
#include "stm32f4/clock_tree.hpp"
#include "stm32f4/pwm.hpp"
#include "stm32f4/send_ring.hpp"
#include "stm32f4/spi.hpp"
#include "stm32f4/timer.hpp"
#include "stm32f4/usart.hpp"
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
    pins::kAmberLed.make_open_drain(true);
    pins::kSensorSupply.make_output(true);
    pins::kPeripheralSupplyOff.make_output(false);
}

// SPI1 by DMA2, streams 2 and 3 (RM0090, table 43). Of 84 MHz: 0.66 and 5.25 MHz, as PX4 has it;
// the part takes 1 and 20.
struct SensorBusSent;
struct SensorBusReceived;
using SensorBus =
    stm32f4::Spi<stm32f4::DmaBuffer<SensorBusSent, 16>, stm32f4::DmaBuffer<SensorBusReceived, 16>>;
using Mpu6000 = drivers::imu::mpu6000::ImuMpu6000::Device;
constexpr SensorBus kSensorBus(0x40013000, stm32f4::DmaStream(2, 3, 3),
                               stm32f4::DmaStream(2, 2, 3));
constexpr uint32_t kSpi1Clock = 1U << 12;  // RCC_APB2ENR
constinit stm32f4::PartOnSpi<kSensorBus, Mpu6000> mpu6000(pins::kMpu6000Select, {6, 3}, imu0);
constexpr stm32f4::MillisecondTick kSensorTick;

// Body x, y, z are the part's y, -x, z: PX4's driver swaps so and starts it without a rotation, and
// ArduPilot has (y, x, -z) turned about x by 180 degrees. The part hangs below the board, so at
// rest its z, which points down, reads -1 g.
void start_sensors() {
    imu0.axes = {2, -1, 3};
    stm32f4::rcc::kApb2Enable.set(kSpi1Clock);
    for (const stm32f4::Pin& line : pins::kSensorBus) line.make_alternate(pins::kSpiFunction);
    kSensorBus.start();
    pins::kMpu6000Ready.start();
    kSensorTick.start();
}

// Outputs AUX 1 to 6, at 400 Hz.
using drivers::motor::pwm::MotorPwm;
constexpr uint32_t kTimer1Clock = 1U << 0;  // RCC_APB2ENR
constexpr uint32_t kTimer4Clock = 1U << 2;  // RCC_APB1ENR
constexpr uint32_t kMotorPeriod_us = 2'500;
constexpr uint32_t kTimer1Channels = 0b1111;
constexpr uint32_t kTimer4Channels = 0b0110;
constexpr stm32f4::PwmTimer kTimer1(0x40010000, stm32f4::kApb2TimerClock_hz, true);
constexpr stm32f4::PwmTimer kTimer4(0x40000800, stm32f4::kApb1TimerClock_hz, false);

const stm32f4::PwmTimer& timer_of(size_t output) {
    return output < 4 ? kTimer1 : kTimer4;
}

void write_motors(const MotorPwm::Pulses& pulses_us) {
    for (size_t i = 0; i < pulses_us.size(); ++i) {
        timer_of(i).write(pins::kMotorChannels[i], pulses_us[i]);
    }
}

// The timers hold the pins low until the first command.
void start_motors() {
    stm32f4::rcc::kApb2Enable.set(kTimer1Clock);
    stm32f4::rcc::kApb1Enable.set(kTimer4Clock);
    kTimer1.start(kMotorPeriod_us, kTimer1Channels);
    kTimer4.start(kMotorPeriod_us, kTimer4Channels);
    for (size_t i = 0; i < pins::kMotorOutputs.size(); ++i) {
        pins::kMotorOutputs[i].make_alternate(pins::kMotorFunctions[i]);
    }
    motors.write = write_motors;
}

// RM0090, 2.3 and 6.3.13. Until the driver starts it, the controller sleeps and sends nothing but
// recessive bits (32.4).
constexpr uint32_t kCan1 = 0x40006400;
constexpr uint32_t kCan1Clock = 1U << 25;

void start_can() {
    can1 = {.base = kCan1, .clock_hz = stm32f4::kApb1Clock_hz, .bit_rate = 1'000'000};
    stm32f4::rcc::kApb1Enable.set(kCan1Clock);
    pins::kCan1Receive.make_alternate(pins::kCanFunction);
    pins::kCan1Send.make_alternate(pins::kCanFunction);
}

bool take_can1(uint32_t interrupts) {
    return bxcan::take_line(bxcan::Memory{kCan1}, interrupts);
}

// RM0090, 2.3 and 6.3.13. The driver starts them, if the graph has it. The rates are PX4's: of a
// radio, and of a computer on board.
using Line = drivers::serial::usart::SerialUsart::Device;
constexpr Line kTelem1{.base = 0x40004400, .clock_hz = stm32f4::kApb1Clock_hz, .baud = 57'600};
constexpr Line kTelem2{.base = 0x40004800, .clock_hz = stm32f4::kApb1Clock_hz, .baud = 921'600};
mav::SharedKey signing_key;
constexpr uint32_t kUsart2Clock = 1U << 17;
constexpr uint32_t kUsart3Clock = 1U << 18;
constexpr uint8_t kUsart2Vector = 38;
constexpr uint8_t kUsart3Vector = 39;
// DMA1 stream 1, TIM3, EXTI15_10, DMA2 stream 2.
constexpr uint8_t kDmaAndSensorVectors[] = {12, 29, 40, 58};

void start_line(const pins::SerialPins& line) {
    line.send.make_alternate(pins::kUsartFunction);
    line.receive.make_alternate(pins::kUsartFunction);
    line.ready.make_output(false);
}

void start_lines() {
    telem1 = kTelem1;
    telem2 = kTelem2;
    telem1.key = telem2.key = &signing_key;
    stm32f4::rcc::kApb1Enable.set(kUsart2Clock | kUsart3Clock);
    start_line(pins::kTelem1);
    start_line(pins::kTelem2);
}

// SERIAL4: motion capture, by DMA1, stream 6 (table 42). A message of 48 bytes takes 0.5 ms, and
// cameras some 5 ms.
struct Serial4Sent;
struct Serial4Received;
constinit stm32f4::Usart<stm32f4::DmaBuffer<Serial4Sent, 4>,
                         stm32f4::DmaBuffer<Serial4Received, 512>>
    serial4(0x40007C00, stm32f4::DmaStream(1, 0, 5), stm32f4::DmaStream(1, 6, 5));
constexpr uint32_t kUart8Clock = 1U << 31;  // RCC_APB1ENR
constexpr uint32_t kMocapBaud = 921'600;
constexpr uint32_t kMocapDelay_us = 5'500;

size_t read_mocap(std::span<uint8_t> bytes) {
    return serial4.read(bytes);
}

void start_mocap() {
    stm32f4::rcc::kApb1Enable.set(kUart8Clock);
    pins::kSerial4Send.make_alternate(pins::kUartFunction);
    pins::kSerial4Receive.make_alternate(pins::kUartFunction);
    if (!serial4.start(stm32f4::kApb1Clock_hz, kMocapBaud)) return;  // it stays silent
    serial4.hear_pauses();
    mocap0 = {.read = read_mocap, .delay_us = kMocapDelay_us};
}

// SERIAL5: the log, by DMA1, stream 1 (table 42), at 5.25 Mbaud. The ring holds what the logger
// says at once of the recording of `quad`, 18 KB within 15 ms, less what goes out meanwhile.
struct LogBytes;
constinit stm32f4::SendRing<stm32f4::DmaBuffer<LogBytes, 16384>> log_line(0x40007800,
                                                                          stm32f4::DmaStream(1, 1,
                                                                                             5));
constexpr uint32_t kUart7Clock = 1U << 30;  // RCC_APB1ENR

bool append_to_log(const uint8_t* bytes, size_t count) {
    return log_line.append(std::span(bytes, count));
}

void start_log() {
    stm32f4::rcc::kApb1Enable.set(kUart7Clock);
    pins::kSerial5Send.make_alternate(pins::kUartFunction);
    log_line.start();
    log_storage.append = append_to_log;
}

// At hardware priority 0.
void enable(uint8_t vector) {
    nvic::priority(vector) = 0;
    nvic::set_enable(vector / 32U).write(1U << vector % 32U);
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

// Runs once: small, not fast.
[[gnu::cold, gnu::noinline]] void prepare() {
    make_safe();
    system0.restart = restart;
    cycles::kDebugControl.set(cycles::kTrace);
    cycles::kControl.set(cycles::kEnable);
    require(stm32f4::start_clocks(kCrystal_mhz) != stm32f4::ClockSource::kNone, "no clock");
    kTimer.start();
    start_pins();
    start_can();
    start_lines();
    start_sensors();
    start_motors();
    start_mocap();
    start_log();
}

// If the hardware does not take the time, the watchdog runs with its longest one.
void start() {
    static_cast<void>(kWatchdog.start(kWatchdog_ms));
    enable(kUsart2Vector);
    enable(kUsart3Vector);
    for (const uint8_t vector : kDmaAndSensorVectors) enable(vector);
}

void usart2_interrupt();
void usart2_interrupt() {
    telem1.interrupt();
}

void usart3_interrupt();
void usart3_interrupt() {
    telem2.interrupt();
}

// The board raises it, and nothing else.
bool take_imu0_data_ready();
bool take_imu0_data_ready() {
    return true;
}

// A pause on SERIAL4: behind a message.
bool take_mocap0_received();
bool take_mocap0_received() {
    return serial4.take_pause();
}

void dma1_stream1_interrupt();
void dma1_stream1_interrupt() {
    log_line.finish();
}

// All three at one priority: none interrupts another.
void exti15_10_interrupt();
void exti15_10_interrupt() {
    pins::kMpu6000Ready.acknowledge();
    mpu6000.ready(clock_us());
}

void tim3_interrupt();
void tim3_interrupt() {
    kSensorTick.acknowledge();
    if (mpu6000.tick(clock_us())) set_pending(lines::imu0_data_ready);
}

void dma2_stream2_interrupt();
void dma2_stream2_interrupt() {
    if (mpu6000.finish()) set_pending(lines::imu0_data_ready);
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
