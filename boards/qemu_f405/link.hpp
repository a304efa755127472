// What firmware and plant tell each other, over two FIFOs: the firmware writes ToPlant, and reads
// one FromPlant after each step. Both sides are little-endian and lay these out alike.
#pragma once

#include <array>
#include <cstdint>

namespace stator::link {

// Files in the emulator's working folder.
inline constexpr char kToPlant[] = "to_plant";
inline constexpr char kFromPlant[] = "from_plant";
inline constexpr char kLog[] = "flight.ulg";

struct ToPlant {
    enum class Kind : uint64_t {
        kStep = 1,      // move the world up to time_us, and answer
        kCommand = 2,   // the motors do this from time_us on
        kFinished = 3,  // the firmware has ended the flight that the plant declared over
    };
    Kind kind = Kind::kStep;
    uint64_t time_us = 0;
    std::array<float, 4> control{};  // as ActuatorMotors has it
    uint64_t activations = 0;
    uint64_t lost_samples = 0;
    uint64_t missed_samples = 0;  // that a device still busy with the one before did not take
};
static_assert(sizeof(ToPlant) == 56);

struct FromPlant {
    uint32_t is_over = 0;  // nothing else counts then
    uint32_t imu_sampled = 0;
    uint32_t mocap_received = 0;
    float mocap_yaw = 0.0f;  // rad
    uint64_t imu_time_us = 0;
    uint64_t mocap_time_us = 0;
    std::array<float, 3> gyro_B{};            // rad/s
    std::array<float, 3> accel_B{};           // m/s^2
    std::array<float, 3> mocap_position_N{};  // m
    uint32_t unused = 0;
};
static_assert(sizeof(FromPlant) == 72);

}  // namespace stator::link
