// What the generated graph connects to: the devices of this board and their lines.
#pragma once

#include <cstdint>
#include <cstdio>

#include "baro_sim.hpp"
#include "battery_sim.hpp"
#include "can_sim.hpp"
#include "gnss_sim.hpp"
#include "imu_sim.hpp"
#include "mag_sim.hpp"
#include "mission_sim.hpp"
#include "mocap_sim.hpp"
#include "motor_sim.hpp"
#include "nonvolatile_sim.hpp"
#include "radio_sim.hpp"
#include "stator/virtual.hpp"
#include "storage_file.hpp"
#include "system_board.hpp"
#include "world.hpp"

namespace stator::board {

extern ImuSim::Device imu0;
extern Line imu0_data_ready;
extern MocapSim::Device mocap0;
extern Line mocap0_received;
extern MotorSim::Device motors;
extern MagSim::Device mag0;
extern Line mag0_data_ready;
extern BaroSim::Device baro0;
extern GnssSim::Device gnss0;
extern Line gnss0_received;
extern RadioSim::Device radio0;
extern Line radio0_received;
extern BatterySim::Device battery0;
extern CanSim::Device can1;
extern Line can1_received;
extern Line can1_sent;
extern Line can1_changed;
extern MissionSim::Device mission0;
extern NonvolatileSim::Device nonvolatile0;  // empty at each start
extern SystemBoard::Device system0;          // a restart ends the flight
extern StorageFile::Device log_storage;

// Before the graph starts: makes the world. It lies where the mission has its origin, if that has a
// place on Earth. `mission` and `truth`, which takes the true flight, may be null.
void prepare(Conditions conditions, const Mission* mission, std::FILE* truth);

const World& world();
bool truth_is_whole();

}  // namespace stator::board
