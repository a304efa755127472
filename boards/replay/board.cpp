// Plays a recording: one instant per sample, in which both devices have theirs.
#include "board.hpp"

namespace stator::board {

ImuRecording::Device imu0;
Line imu0_data_ready;
MagRecording::Device mag0;
Line mag0_data_ready;
StorageFile::Device log_storage;

namespace {

const Recording* recording = nullptr;
std::size_t next_sample = 0;

}  // namespace

void replay(const Recording& chosen) {
    recording = &chosen;
    next_sample = 0;
}

std::uint64_t next_event_us() {
    return next_sample < recording->samples() ? Recording::time_us(next_sample) : kNever;
}

void advance(std::uint64_t now_us) {
    for (; next_event_us() <= now_us; ++next_sample) {
        const std::uint64_t time_us = next_event_us();
        imu0 = {.timestamp_sample = time_us,
                .gyro_B = recording->xyz(Recording::Plane::kGyro, next_sample),
                .accel_B = recording->xyz(Recording::Plane::kAccel, next_sample)};
        mag0 = {.timestamp_sample = time_us,
                .field_B_ut = recording->xyz(Recording::Plane::kMag, next_sample)};
        imu0_data_ready.raise();
        mag0_data_ready.raise();
    }
}

}  // namespace stator::board
