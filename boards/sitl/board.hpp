// What the generated graph connects to: the devices of this board and their lines.
#pragma once

#include <cstdint>
#include <cstdio>

#include "imu_sim.hpp"
#include "mocap_sim.hpp"
#include "motor_sim.hpp"
#include "stator/virtual.hpp"
#include "storage_file.hpp"
#include "world.hpp"

namespace stator::board {

extern ImuSim::Device imu0;
extern Line imu0_data_ready;
extern MocapSim::Device mocap0;
extern Line mocap0_received;
extern MotorSim::Device motors;
extern StorageFile::Device log_storage;

// Before the graph starts: makes the world of this seed. `truth` takes the true flight; may be
// null.
void prepare(std::uint64_t seed, std::FILE* truth);

const World& world();
bool truth_is_whole();

}  // namespace stator::board
