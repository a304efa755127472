// What the generated graph connects to: the devices of this board and their lines.
#pragma once

#include "baro_recording.hpp"
#include "gnss_recording.hpp"
#include "imu_recording.hpp"
#include "mag_recording.hpp"
#include "nonvolatile_sim.hpp"
#include "recording.hpp"
#include "stator/virtual.hpp"
#include "storage_file.hpp"

namespace stator::board {

extern ImuRecording::Device imu0;
extern Line imu0_data_ready;
extern MagRecording::Device mag0;
extern Line mag0_data_ready;
extern GnssRecording::Device gnss0;
extern Line gnss0_received;
extern BaroRecording::Device baro0;
extern NonvolatileSim::Device nonvolatile0;  // there is none: loading fails
extern StorageFile::Device log_storage;

// Before the graph starts: what to play. It must outlive the run.
void play(const Recording& chosen);

}  // namespace stator::board
