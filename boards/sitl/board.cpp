// Ties the simulated world to virtual time and to the devices that drivers see.
#include <algorithm>
#include <optional>

#include "devices.hpp"
#include "flight.hpp"
#include "hand_over.hpp"
#include "links_of_flight.hpp"
#include "outside.hpp"
#include "sensors.hpp"
#include "stator/virtual.hpp"
#include "world/can_bus.hpp"
#include "world/can_parts.hpp"
#include "world/ending.hpp"
#include "world/truth.hpp"

namespace stator::board {

namespace {

using drivers::can::sim::CanSim;
using drivers::motor::sim::MotorSim;
using drivers::nonvolatile::sim::NonvolatileSim;
using drivers::servo::sim::ServoSim;

// Of one flight: our own world, or the outside one in its place.
std::optional<world::World> the_world;
Outside* outside = nullptr;
world::CanBus can_bus;
std::optional<Sensors> sensors;
std::optional<world::CanParts> can_parts;
std::FILE* mission_file = nullptr;
std::FILE* truth_file = nullptr;
bool truth_was_written = false;
std::array<std::uint8_t, NonvolatileSim::kBytes> nonvolatile_memory{};

// The register write of the motor driver. Time may have passed since the newest event.
void write_motors(const MotorSim::Control& control) {
    if (outside != nullptr) {
        outside->command_motors(control);
    } else {
        the_world->command_motors(executor.now_us, control);
    }
}

// The same of the servos. Another simulator has its own.
void write_servos(const ServoSim::Control& control) {
    if (outside == nullptr) the_world->command_servos(executor.now_us, control);
}

void send_on_can(const CanSim::Frame& frame) {
    can_bus.send({.id = frame.id, .length = frame.length, .data = frame.data},
                 world::CanBus::Sender::kVehicle, executor.now_us);
}

// The end of a frame on the bus: everybody but its sender has it.
void finish_can_frame() {
    const world::CanBus::Sent sent = can_bus.finish();
    if (sent.sender == world::CanBus::Sender::kVehicle) {
        const auto control = can_parts->receive(sent.frame, sent.end_us);
        if (control) the_world->command_motors(sent.end_us, *control);
        can1_sent.raise();
        return;
    }
    can1.receive({.timestamp_sample = sent.end_us,
                  .id = sent.frame.id,
                  .length = sent.frame.length,
                  .data = sent.frame.data});
    can1_received.raise();
}

void run_can_parts() {
    can_parts->run(*the_world);
    const std::uint64_t now_us = the_world->time_us();
    if (can_parts->times_out(now_us)) {
        world::CanParts::Control stopped;
        stopped.fill(math::canonical_nan<float>());
        the_world->command_motors(now_us, stopped);
    }
}

// How a device gets its sample: its driver waits for the line, or asks now and then.
struct Give {
    template <class Device, class Sample>
    void operator()(Device& device, const Sample& sample, Line& line) const {
        device = sample;
        line.raise();
    }
    template <class Device, class Sample>
    void operator()(Device& device, const Sample& sample) const {
        device.put(sample);
    }
};

void measure() {
    Samples samples;
    sensors->measure(*the_world, samples);
    hand_over(samples, Give{});
}

bool seek_mission(std::uint32_t address) {
    return mission_file != nullptr &&
           std::fseek(mission_file, static_cast<long>(address), SEEK_SET) == 0;
}

void record_truth() {
    if (truth_file == nullptr || the_world->time_us() % world::kTruthPeriod_us != 0) return;
    truth_was_written = world::write_truth(truth_file, *the_world) && truth_was_written;
}

void advance_outside(std::uint64_t now_us) {
    if (outside->time_us() > now_us) return;
    Samples samples;
    outside->take(samples);
    hand_over(samples, Give{});
}

void connect_devices(std::FILE* mission) {
    mission_file = mission;
    mission0.read = [](std::uint32_t address, std::span<std::uint8_t> bytes) {
        return seek_mission(address) &&
               std::fread(bytes.data(), 1, bytes.size(), mission_file) == bytes.size();
    };
    mission0.write = [](std::uint32_t address, std::span<const std::uint8_t> bytes) {
        return seek_mission(address) &&
               std::fwrite(bytes.data(), 1, bytes.size(), mission_file) == bytes.size();
    };
    system0.restart = stop;
    motors.write = write_motors;
    servos.write = write_servos;
    nonvolatile0.read = [](std::uint32_t address, std::span<std::uint8_t> bytes) {
        std::copy_n(nonvolatile_memory.begin() + address, bytes.size(), bytes.begin());
        return true;
    };
    nonvolatile0.write = [](std::uint32_t address, std::span<const std::uint8_t> bytes) {
        std::copy(bytes.begin(), bytes.end(), nonvolatile_memory.begin() + address);
        return true;
    };
}

}  // namespace

void prepare(const world::Conditions& conditions, const world::Vehicle& vehicle, std::FILE* mission,
             std::FILE* truth) {
    connect_devices(mission);
    the_world.emplace(conditions, vehicle);
    sensors.emplace(*the_world);
    can_parts.emplace(*the_world, [](const dronecan::Frame& frame, std::uint64_t now_us) {
        can_bus.send(frame, world::CanBus::Sender::kParts, now_us);
    });
    truth_file = truth;
    truth_was_written = truth == nullptr || world::write_truth_head(truth, *the_world);
    can1.send = send_on_can;
}

void prepare(Outside& other, std::FILE* mission) {
    connect_devices(mission);
    outside = &other;
    truth_was_written = true;
}

const world::World& world() {
    return *the_world;
}
bool truth_is_whole() {
    return truth_was_written;
}

std::uint64_t next_event_us() {
    if (outside != nullptr) return outside->next_event_us(executor.now_us);
    return std::min({the_world->next_event_us(), can_bus.next_event_us(), next_link_event_us()});
}

bool is_over() {
    const bool ends = outside != nullptr ? outside->is_over() || !outside->problem().empty()
                                         : the_world->is_over();
    return ends || world::ending_signal.load() != 0;
}

void advance(std::uint64_t now_us) {
    if (outside != nullptr) {
        advance_outside(now_us);
        if (is_over()) stop();
        return;
    }
    while (next_event_us() <= now_us) {
        if (can_bus.next_event_us() < std::min(the_world->next_event_us(), next_link_event_us())) {
            finish_can_frame();
            continue;
        }
        if (next_link_event_us() < the_world->next_event_us()) {
            take_link_event();
            continue;
        }
        the_world->move_to_next_event();
        measure();
        run_can_parts();
        record_truth();
    }
    if (is_over()) stop();
}

}  // namespace stator::board
