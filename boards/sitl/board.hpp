// What the generated graph connects to: the devices of this board and their lines.
#pragma once

#include <cstdint>
#include <cstdio>

#include "drivers/baro/sim/baro_sim.hpp"
#include "drivers/battery/sim/battery_sim.hpp"
#include "drivers/can/sim/can_sim.hpp"
#include "drivers/gnss/sim/gnss_sim.hpp"
#include "drivers/imu/sim/imu_sim.hpp"
#include "drivers/mag/sim/mag_sim.hpp"
#include "drivers/mission/sim/mission_sim.hpp"
#include "drivers/mocap/sim/mocap_sim.hpp"
#include "drivers/motor/sim/motor_sim.hpp"
#include "drivers/nonvolatile/sim/nonvolatile_sim.hpp"
#include "drivers/radio/sim/radio_sim.hpp"
#include "stator/virtual.hpp"
#include "drivers/storage/file/storage_file.hpp"
#include "drivers/system/board/system_board.hpp"
#include "world.hpp"

namespace stator::board {

extern drivers::imu::sim::ImuSim::Device imu0;
extern Line imu0_data_ready;
extern drivers::mocap::sim::MocapSim::Device mocap0;
extern Line mocap0_received;
extern drivers::motor::sim::MotorSim::Device motors;
extern drivers::mag::sim::MagSim::Device mag0;
extern Line mag0_data_ready;
extern drivers::baro::sim::BaroSim::Device baro0;
extern drivers::gnss::sim::GnssSim::Device gnss0;
extern Line gnss0_received;
extern drivers::radio::sim::RadioSim::Device radio0;
extern Line radio0_received;
extern drivers::battery::sim::BatterySim::Device battery0;
extern drivers::can::sim::CanSim::Device can1;
extern Line can1_received;
extern Line can1_sent;
extern Line can1_changed;
extern drivers::mission::sim::MissionSim::Device mission0;
extern drivers::nonvolatile::sim::NonvolatileSim::Device nonvolatile0;  // empty at each start
extern drivers::system::board::SystemBoard::Device system0;          // a restart ends the flight
extern drivers::storage::file::StorageFile::Device log_storage;

// Before the graph starts: makes the world. It lies where the mission has its origin, if that has a
// place on Earth. `mission` and `truth`, which takes the true flight, may be null.
void prepare(Conditions conditions, const Mission* mission, std::FILE* truth);

const World& world();
bool truth_is_whole();

}  // namespace stator::board
