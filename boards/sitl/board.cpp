// Ties the simulated world to virtual time and to the devices that drivers see.
#include "board.hpp"

#include <optional>

#include "fill.hpp"
#include "truth.hpp"

namespace stator::board {

ImuSim::Device imu0;
Line imu0_data_ready;
MocapSim::Device mocap0;
Line mocap0_received;
MotorSim::Device motors;
MagSim::Device mag0;
Line mag0_data_ready;
BaroSim::Device baro0;
GnssSim::Device gnss0;
Line gnss0_received;
RadioSim::Device radio0;
Line radio0_received;
BatterySim::Device battery0;
StorageFile::Device log_storage;

namespace {

std::optional<World> the_world;
std::FILE* truth_file = nullptr;
bool truth_was_written = true;

// The register write of the motor driver. Time may have passed since the newest event.
void write_motors(const MotorSim::Control& control) {
    the_world->command_motors(executor.now_us, {control[0], control[1], control[2], control[3]});
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
    fill(battery0, the_world->battery());
}

void record_truth() {
    const Plant& plant = the_world->plant();
    if (truth_file == nullptr || plant.time_us() % kTruthPeriod_us != 0) return;
    truth_was_written = write_truth(truth_file, plant) && truth_was_written;
}

}  // namespace

void prepare(const Conditions& conditions, std::FILE* truth) {
    the_world.emplace(conditions);
    truth_file = truth;
    motors.write = write_motors;
}

const World& world() {
    return *the_world;
}
bool truth_is_whole() {
    return truth_was_written;
}

std::uint64_t next_event_us() {
    return the_world->next_event_us();
}

void advance(std::uint64_t now_us) {
    while (the_world->next_event_us() <= now_us) {
        const World::Event event = the_world->move_to_next_event();
        hand_over(event, the_world->plant().time_us());
        record_truth();
    }
    if (the_world->is_over()) stop();
}

}  // namespace stator::board
