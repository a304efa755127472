// Devices of this board: the world's thread fills them, the drivers read them.
#include "board.hpp"

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
drivers::can::socketcan::CanSocketcan::Device can1;
Line can1_received;
Line can1_sent;
Line can1_changed;
drivers::nonvolatile::file::NonvolatileFile::Device nonvolatile0;
drivers::system::board::SystemBoard::Device system0{.restart = stop};
drivers::storage::file::StorageFile::Device log_storage;

}  // namespace stator::board
