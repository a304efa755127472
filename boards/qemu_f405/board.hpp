// What the generated graph connects to: the devices of this board.
#pragma once

#include "baro_sim.hpp"
#include "battery_sim.hpp"
#include "gnss_sim.hpp"
#include "imu_sim.hpp"
#include "mag_sim.hpp"
#include "mocap_sim.hpp"
#include "motor_sim.hpp"
#include "nonvolatile_sim.hpp"
#include "radio_sim.hpp"
#include "storage_sim.hpp"
#include "system_board.hpp"

namespace stator::board {

extern ImuSim::Device imu0;
extern MocapSim::Device mocap0;
extern MotorSim::Device motors;
extern MagSim::Device mag0;
extern BaroSim::Device baro0;
extern GnssSim::Device gnss0;
extern RadioSim::Device radio0;
extern BatterySim::Device battery0;
extern NonvolatileSim::Device nonvolatile0;
extern SystemBoard::Device system0;
extern StorageSim::Device log_storage;

}  // namespace stator::board
