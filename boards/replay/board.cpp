// Plays a recording: each row is written to its device when it arrived.
#include "board.hpp"

namespace stator::board {

drivers::imu::recording::ImuRecording::Device imu0;
Line imu0_data_ready;
drivers::mag::recording::MagRecording::Device mag0;
Line mag0_data_ready;
drivers::gnss::recording::GnssRecording::Device gnss0;
Line gnss0_received;
drivers::baro::recording::BaroRecording::Device baro0;
drivers::nonvolatile::sim::NonvolatileSim::Device nonvolatile0;
drivers::storage::file::StorageFile::Device log_storage;

namespace {

const Recording* recording = nullptr;
std::size_t next_row = 0;

std::array<float, 3> xyz(const Row& row, std::size_t first) {
    return {static_cast<float>(row.values[first]), static_cast<float>(row.values[first + 1]),
            static_cast<float>(row.values[first + 2])};
}

SensorGps fix_of(const Row& row) {
    const auto velocity = xyz(row, 3);
    const auto errors = xyz(row, 6);
    return {.timestamp_sample = static_cast<std::uint64_t>(row.timestamp_sample),
            .latitude_deg = row.values[0],
            .longitude_deg = row.values[1],
            .altitude_msl_m = row.values[2],
            .altitude_ellipsoid_m = row.values[2],
            .s_variance_m_s = errors[2],
            .eph = errors[0],
            .epv = errors[1],
            .vel_n_m_s = velocity[0],
            .vel_e_m_s = velocity[1],
            .vel_d_m_s = velocity[2],
            .fix_type = SensorGps::FixType::kFix3d,
            .vel_ned_valid = true,
            .satellites_used = 0};
}

void show(const Row& row) {
    const auto sample_us = static_cast<std::uint64_t>(row.timestamp_sample);
    switch (static_cast<int>(row.device)) {
        case Row::kImu:
            imu0 = {.timestamp_sample = sample_us, .gyro_B = xyz(row, 0), .accel_B = xyz(row, 3)};
            imu0_data_ready.raise();
            break;
        case Row::kMag:
            mag0 = {.timestamp_sample = sample_us, .field_B = xyz(row, 0)};
            mag0_data_ready.raise();
            break;
        case Row::kGnss:
            gnss0.fix = fix_of(row);
            gnss0_received.raise();
            break;
        case Row::kBaro:
            baro0 = {.timestamp_sample = sample_us,
                     .samples = baro0.samples + 1,
                     .pressure = static_cast<float>(row.values[0])};
            break;
        default:
            break;
    }
}

}  // namespace

void replay(const Recording& chosen) {
    recording = &chosen;
    next_row = 0;
}

std::uint64_t next_event_us() {
    return next_row < recording->size() ? Recording::time_us((*recording)[next_row]) : kNever;
}

void advance(std::uint64_t now_us) {
    for (; next_event_us() <= now_us; ++next_row) show((*recording)[next_row]);
}

}  // namespace stator::board
