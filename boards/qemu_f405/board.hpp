// What the generated graph connects to: the devices of this board.
#pragma once

#include "drivers/baro/sim/baro_sim.hpp"
#include "drivers/battery/sim/battery_sim.hpp"
#include "drivers/gnss/sim/gnss_sim.hpp"
#include "drivers/imu/sim/imu_sim.hpp"
#include "drivers/mag/sim/mag_sim.hpp"
#include "drivers/mocap/sim/mocap_sim.hpp"
#include "drivers/motor/sim/motor_sim.hpp"
#include "drivers/nonvolatile/sim/nonvolatile_sim.hpp"
#include "drivers/radio/sim/radio_sim.hpp"
#include "drivers/storage/sim/storage_sim.hpp"
#include "drivers/system/board/system_board.hpp"

namespace stator::board {

extern drivers::imu::sim::ImuSim::Device imu0;
extern drivers::mocap::sim::MocapSim::Device mocap0;
extern drivers::motor::sim::MotorSim::Device motors;
extern drivers::mag::sim::MagSim::Device mag0;
extern drivers::baro::sim::BaroSim::Device baro0;
extern drivers::gnss::sim::GnssSim::Device gnss0;
extern drivers::radio::sim::RadioSim::Device radio0;
extern drivers::battery::sim::BatterySim::Device battery0;
extern drivers::nonvolatile::sim::NonvolatileSim::Device nonvolatile0;
extern drivers::system::board::SystemBoard::Device system0;
extern drivers::storage::sim::StorageSim::Device log_storage;

}  // namespace stator::board
