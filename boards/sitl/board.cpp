// Ties the simulated world to virtual time and to the devices that drivers see.
#include "board.hpp"

#include <algorithm>
#include <optional>

#include "can_bus.hpp"
#include "can_parts.hpp"
#include "fill.hpp"
#include "truth.hpp"

namespace stator::board {

drivers::imu::sim::ImuSim::Device imu0;
Line imu0_data_ready;
drivers::mocap::sim::MocapSim::Device mocap0;
Line mocap0_received;
drivers::motor::sim::MotorSim::Device motors;
drivers::mag::sim::MagSim::Device mag0;
Line mag0_data_ready;
drivers::baro::sim::BaroSim::Device baro0;
drivers::gnss::sim::GnssSim::Device gnss0;
Line gnss0_received;
drivers::radio::sim::RadioSim::Device radio0;
Line radio0_received;
drivers::battery::sim::BatterySim::Device battery0;
drivers::can::sim::CanSim::Device can1;
Line can1_received;
Line can1_sent;
Line can1_changed;
drivers::mission::sim::MissionSim::Device mission0;
drivers::nonvolatile::sim::NonvolatileSim::Device nonvolatile0;
drivers::system::board::SystemBoard::Device system0{.restart = stop};
drivers::storage::file::StorageFile::Device log_storage;

namespace {

std::optional<World> the_world;
CanBus can_bus;
CanParts can_parts([](const dronecan::Frame& frame, std::uint64_t now_us) {
    can_bus.send(frame, CanBus::Sender::kParts, now_us);
});
std::FILE* truth_file = nullptr;
bool truth_was_written = false;
std::array<std::uint8_t, drivers::nonvolatile::sim::NonvolatileSim::kBytes> nonvolatile_memory{};

// The register write of the motor driver. Time may have passed since the newest event.
void write_motors(const drivers::motor::sim::MotorSim::Control& control) {
    the_world->command_motors(executor.now_us, {control[0], control[1], control[2], control[3]});
}

void send_on_can(const drivers::can::sim::CanSim::Frame& frame) {
    can_bus.send({.id = frame.id, .length = frame.length, .data = frame.data},
                 CanBus::Sender::kVehicle, executor.now_us);
}

// The end of a frame on the bus: everybody but its sender has it.
void finish_can_frame() {
    const CanBus::Sent sent = can_bus.finish();
    if (sent.sender == CanBus::Sender::kVehicle) {
        const auto control = can_parts.receive(sent.frame, sent.end_us);
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

void run_can_parts(const std::optional<GnssFix>& fix) {
    can_parts.run(*the_world, fix);
    const std::uint64_t now_us = the_world->plant().time_us();
    if (can_parts.times_out(now_us)) {
        CanParts::Control stopped;
        stopped.fill(math::canonical_nan<float>());
        the_world->command_motors(now_us, stopped);
    }
}

void hand_over(const World::Event& event, std::uint64_t now_us) {
    if (event.imu) {
        imu0 = {.timestamp_sample = now_us,
                .gyro_B = math::to_array(event.imu->gyro_B),
                .accel_B = math::to_array(event.imu->accel_B)};
        imu0_data_ready.raise();
    }
    if (event.mocap) {
        mocap0 = {.timestamp_sample = event.mocap->time_us,
                  .position_N = math::to_array(event.mocap->position_N),
                  .yaw = event.mocap->yaw};
        mocap0_received.raise();
    }
    if (event.mag_B) {
        mag0 = {.timestamp_sample = now_us, .field_B_gauss = math::to_array(*event.mag_B)};
        mag0_data_ready.raise();
    }
    if (event.baro) fill(baro0, *event.baro, now_us);
    if (event.gnss) {
        fill(gnss0, *event.gnss);
        gnss0_received.raise();
    }
    if (event.radio) {
        fill(radio0, *event.radio, now_us);
        radio0_received.raise();
    }
    if (event.battery_measured) fill(battery0, the_world->battery());
}

// A mission without items stands for one that was lost.
void lose_mission() {
    if (!the_world->mission_is_lost() || mission0.mission.count == 0) return;
    mission0.mission.count = 0;
    ++mission0.version;
}

void record_truth() {
    if (truth_file == nullptr || the_world->plant().time_us() % kTruthPeriod_us != 0) return;
    truth_was_written = write_truth(truth_file, *the_world) && truth_was_written;
}

}  // namespace

void prepare(Conditions conditions, const Mission* mission, std::FILE* truth) {
    if (mission != nullptr) {
        mission0 = {.mission = *mission, .version = 1};
        if (math::is_finite(mission->origin_lat)) {
            conditions.earth.latitude_deg = mission->origin_lat;
            conditions.earth.longitude_deg = mission->origin_lon;
        }
    }
    the_world.emplace(conditions);
    truth_file = truth;
    truth_was_written = truth == nullptr || write_truth_head(truth);
    motors.write = write_motors;
    can1.send = send_on_can;
    nonvolatile0.read = [](std::uint32_t address, std::span<std::uint8_t> bytes) {
        std::copy_n(nonvolatile_memory.begin() + address, bytes.size(), bytes.begin());
        return true;
    };
    nonvolatile0.write = [](std::uint32_t address, std::span<const std::uint8_t> bytes) {
        std::copy(bytes.begin(), bytes.end(), nonvolatile_memory.begin() + address);
        return true;
    };
}

const World& world() {
    return *the_world;
}
bool truth_is_whole() {
    return truth_was_written;
}

std::uint64_t next_event_us() {
    return std::min(the_world->next_event_us(), can_bus.next_event_us());
}

void advance(std::uint64_t now_us) {
    while (next_event_us() <= now_us) {
        if (can_bus.next_event_us() < the_world->next_event_us()) {
            finish_can_frame();
            continue;
        }
        const World::Event event = the_world->move_to_next_event();
        hand_over(event, the_world->plant().time_us());
        run_can_parts(event.gnss);
        lose_mission();
        record_truth();
    }
    if (the_world->is_over()) stop();
}

}  // namespace stator::board
