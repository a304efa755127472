// Ties the emulated chip to the simulated world on the host: each millisecond, at hardware priority
// 0, the world moves up to now, fills the devices that sampled meanwhile, and pends their vectors.
#include <algorithm>
#include <limits>
#include <utility>

#include "devices.hpp"
#include "hand_over.hpp"
#include "link.hpp"
#include "semihosting.hpp"
#include "serial.hpp"
#include "stator/cortex_m.hpp"
#include "stator/recording.hpp"
#include "timers.hpp"

namespace stator::board {

namespace {

using drivers::motor::sim::MotorSim;
using drivers::servo::sim::ServoSim;

constexpr uint8_t kAnyVector = 28;
constexpr uint32_t kPriorityBits = 0xF0;

// The clock of their bus; the emulator does not divide it.
constexpr uint32_t kLineClock_hz = 42'000'000;
constexpr uint8_t kUsart2Vector = 38;
constexpr uint8_t kUsart3Vector = 39;

constexpr Clock kClock;
bool is_kicked = false;
SerialPort serial;
constexpr Transport kLink{
    .read = [](uint8_t* bytes, size_t most) { return serial.read(bytes, most); },
    .write = [](const uint8_t* bytes, size_t count) { return serial.write(bytes, count); },
};
semihosting::File to_plant;
semihosting::File from_plant;
semihosting::File log_file;
semihosting::File nonvolatile_file;
semihosting::File mission_file;
mav::SharedKey signing_key;
uint64_t missed_samples = 0;

// The register write of the motor driver.
void write_motors(const MotorSim::Control& control) {
    const link::ToPlant message{
        .kind = link::ToPlant::Kind::kCommand, .time_us = clock_us(), .control = control};
    require(to_plant.write(&message, sizeof message), "the plant does not listen");
}

void write_servos(const ServoSim::Control& control) {
    link::ToPlant message{.kind = link::ToPlant::Kind::kServos, .time_us = clock_us()};
    std::copy(control.begin(), control.end(), message.control.begin());
    require(to_plant.write(&message, sizeof message), "the plant does not listen");
}

bool append(const uint8_t* bytes, size_t count) {
    return log_file.write(bytes, count);
}

// A file of the host stands for the memory, so that a reset leaves it as it is.
bool read_nonvolatile(uint32_t address, std::span<uint8_t> bytes) {
    return nonvolatile_file.seek(link::kNonvolatileHead + address) &&
           nonvolatile_file.read(bytes.data(), bytes.size());
}
bool write_nonvolatile(uint32_t address, std::span<const uint8_t> bytes) {
    return nonvolatile_file.seek(link::kNonvolatileHead + address) &&
           nonvolatile_file.write(bytes.data(), bytes.size());
}

bool read_mission(uint32_t address, std::span<uint8_t> bytes) {
    return mission_file.seek(address) && mission_file.read(bytes.data(), bytes.size());
}
bool write_mission(uint32_t address, std::span<const uint8_t> bytes) {
    return mission_file.seek(address) && mission_file.write(bytes.data(), bytes.size());
}

// At hardware priority 0.
void enable(uint8_t vector) {
    nvic::priority(vector) = 0;
    nvic::set_enable(vector / 32U).write(1U << vector % 32U);
}

// For the host: codegen/stator/emulator/figures.py reads it. In the order of the plan; ticks and
// us.
void print_figures() {
    for (unsigned i = 0; i < program.task_count; ++i) {
        const TaskCounters& counters = *program.tasks[i].counters;
        semihosting::print("stator: task ");
        for (const uint32_t figure :
             {counters.activations, counters.most_ticks, counters.latest_us}) {
            semihosting::print(figure);
            semihosting::print(" ");
        }
        semihosting::print("\n");
    }
}

[[noreturn]] void finish() {
    if (semihosting::was_told(link::kFigures)) print_figures();
    const RecordingCounts recording = recording_counts();
    link::ToPlant message{
        .kind = link::ToPlant::Kind::kFinished,
        .time_us = clock_us(),
        .missed_samples = missed_samples,
        .preemptions = recording.preemptions,
        .unrecorded_activations = recording.lost,
        .missed_life_signs = missed_life_signs(program.watched, program.watched_count),
        .restarts = system0.restarts};
    for (unsigned i = 0; i < program.task_count; ++i) {
        message.activations += program.tasks[i].counters->activations;
        message.lost_samples += program.tasks[i].counters->lost_samples;
    }
    const bool told = to_plant.write(&message, sizeof message);
    semihosting::exit(told && log_storage.errors == 0 ? 0 : 1);
}

// The world would go on without the firmware, so a flight ends here; but tests want to see more.
void restart_or_finish() {
    if (semihosting::was_told(link::kRestart)) restart();
    finish();
}

// A device whose task may be reading it keeps its sample, and the new one is gone. One that the
// graph does not use has no task.
bool can_take(const Pend& line) {
    if ((nvic::set_enable(line.word).read() & line.mask) == 0) return false;
    if (!is_busy(line)) return true;
    ++missed_samples;
    return false;
}

struct Give {
    template <class Device, class Sample>
    void operator()(Device& device, const Sample& sample, const Pend& line) const {
        if (!can_take(line)) return;
        device = sample;
        set_pending(line);
    }
    template <class Device, class Sample>
    void operator()(Device& device, const Sample& sample) const {
        device.put(sample);
    }
};

}  // namespace

// 8 ns an instruction: codegen/stator/emulator/qemu.py.
extern const TickSource kTickSource{1'000'000'000, 1, 8};
uint32_t ticks() {
    return kWatchdogTimer.ns();
}

uint32_t timer_us() {
    return kClock.us();
}

void prepare() {
    kClock.start();
    nvic::priority(kAnyVector) = 0xFF;
    require(nvic::priority(kAnyVector) == kPriorityBits,
            "this emulator lacks the chip's 4 priority bits: QEMU 10 is needed");
    require(to_plant.open(link::kToPlant, semihosting::Mode::kWrite) &&
                from_plant.open(link::kFromPlant, semihosting::Mode::kRead),
            "the plant is missing: ./stator emulate starts one");
    require(log_file.open(link::kLog, semihosting::Mode::kWrite), "cannot open the log");
    motors.write = write_motors;
    servos.write = write_servos;
    log_storage.append = append;
    system0.restart = restart_or_finish;
    parameter_box = &terminal0.box;
    require(nonvolatile_file.open(link::kNonvolatile, semihosting::Mode::kChange),
            "cannot open the file of the nonvolatile memory");
    nonvolatile0 = {.read = read_nonvolatile, .write = write_nonvolatile, .key = &signing_key};
    telem1 = {.base = 0x40004400, .clock_hz = kLineClock_hz, .baud = link::kLine_baud[0]};
    telem2 = {.base = 0x40004800, .clock_hz = kLineClock_hz, .baud = link::kLine_baud[1]};
    telem1.key = telem2.key = &signing_key;
    if (mission_file.open(link::kMission, semihosting::Mode::kChange)) {
        mission0.read = read_mission;
        mission0.write = write_mission;
    }
}

void start() {
    kStepTimer.start();
    kWatchdogTimer.start();
    serial.start();
    enable(kUsart2Vector);
    enable(kUsart3Vector);
    link_transport = &kLink;
}

void usart1_interrupt();
void usart1_interrupt() {
    serial.receive();
}

void usart2_interrupt();
void usart2_interrupt() {
    telem1.interrupt();
}

void usart3_interrupt();
void usart3_interrupt() {
    telem2.interrupt();
}

void tim2_interrupt();
void tim2_interrupt() {
    kStepTimer.acknowledge();
    const link::ToPlant step{.kind = link::ToPlant::Kind::kStep, .time_us = clock_us()};
    link::FromPlant answer;
    require(to_plant.write(&step, sizeof step) && from_plant.read(&answer, sizeof answer),
            "the plant is gone");
    if (answer.is_over != 0) finish();
    hand_over(answer.samples, Give{});
}

[[gnu::naked]] void tim3_interrupt();
void tim3_interrupt() {
    asm volatile("b %c0" ::"i"(stator_watchdog_timer));
}

void kick_watchdog() {
    is_kicked = true;
}
bool watchdog_was_kicked() {
    kWatchdogTimer.acknowledge();
    return std::exchange(is_kicked, false);
}

// The plant stops its motors at a value that is not a number.
void make_safe() {
    constexpr float kStopped = std::numeric_limits<float>::quiet_NaN();
    link::ToPlant message{.kind = link::ToPlant::Kind::kCommand, .time_us = clock_us()};
    message.control.fill(kStopped);
    // Where there is no plant there are no motors.
    if (to_plant.is_open()) static_cast<void>(to_plant.write(&message, sizeof message));
}

// For the host: codegen/stator/live/fault_record.py reads it. The flight is over then, as the world
// has gone on; but tests want to see more resets than one.
void report(const FaultRecord& record) {
    semihosting::print("stator: record ");
    const auto* bytes = reinterpret_cast<const uint8_t*>(&record);
    for (size_t i = 0; i < sizeof record; ++i) semihosting::print_byte(bytes[i]);
    semihosting::print("\n");
    if (is_safe_mode() || !semihosting::was_told(link::kRestart)) semihosting::exit(1);
}

}  // namespace stator::board
