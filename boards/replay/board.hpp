// What the generated graph connects to: the devices of this board and their lines.
#pragma once

#include "drivers/baro/recording/baro_recording.hpp"
#include "drivers/gnss/recording/gnss_recording.hpp"
#include "drivers/imu/recording/imu_recording.hpp"
#include "drivers/mag/recording/mag_recording.hpp"
#include "drivers/nonvolatile/sim/nonvolatile_sim.hpp"
#include "recording.hpp"
#include "stator/virtual.hpp"
#include "drivers/storage/file/storage_file.hpp"

namespace stator::board {

extern drivers::imu::recording::ImuRecording::Device imu0;
extern Line imu0_data_ready;
extern drivers::mag::recording::MagRecording::Device mag0;
extern Line mag0_data_ready;
extern drivers::gnss::recording::GnssRecording::Device gnss0;
extern Line gnss0_received;
extern drivers::baro::recording::BaroRecording::Device baro0;
extern drivers::nonvolatile::sim::NonvolatileSim::Device nonvolatile0;  // there is none: loading fails
extern drivers::storage::file::StorageFile::Device log_storage;

// Before the graph starts: what to replay. It must outlive the run.
void replay(const Recording& chosen);

}  // namespace stator::board
