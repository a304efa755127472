// Devices of this board: the world's thread fills them, the drivers read them.
#include "board.hpp"

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
CanSocketcan::Device can1;
Line can1_received;
Line can1_sent;
Line can1_changed;
NonvolatileFile::Device nonvolatile0;
SystemBoard::Device system0{.restart = stop};
StorageFile::Device log_storage;

}  // namespace stator::board
