// What the generated graph connects to: the devices of this board and their lines.
#pragma once

#include "baro_sim.hpp"
#include "battery_sim.hpp"
#include "can_socketcan.hpp"
#include "gnss_sim.hpp"
#include "imu_sim.hpp"
#include "mag_sim.hpp"
#include "mocap_sim.hpp"
#include "motor_sim.hpp"
#include "nonvolatile_file.hpp"
#include "radio_sim.hpp"
#include "stator/pthread.hpp"
#include "storage_file.hpp"
#include "system_board.hpp"

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
extern CanSocketcan::Device can1;
extern Line can1_received;
extern Line can1_sent;     // never raised: the driver tries again with its timer
extern Line can1_changed;  // never raised: that is received, too
extern NonvolatileFile::Device nonvolatile0;
extern SystemBoard::Device system0;  // a restart ends the process
extern StorageFile::Device log_storage;

}  // namespace stator::board
