// What the generated graph connects to: the devices of this board.
#pragma once

#include "imu_sim.hpp"
#include "mocap_sim.hpp"
#include "motor_sim.hpp"
#include "storage_sim.hpp"

namespace stator::board {

extern ImuSim::Device imu0;
extern MocapSim::Device mocap0;
extern MotorSim::Device motors;
extern StorageSim::Device log_storage;

}  // namespace stator::board
