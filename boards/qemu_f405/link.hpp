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
inline constexpr char kNonvolatile[] = "nonvolatile";
// As a word for the firmware: start again after a fault or when asked to, instead of ending the
// emulation.
inline constexpr char kRestart[] = "restart";

struct ToPlant {
    enum class Kind : uint64_t {
        kStep = 1,     // move the world up to time_us, and answer
        kCommand = 2,  // the motors do this from time_us on
        kFinished =
            3,  // the firmware has ended the flight, mostly after the plant declared it over
    };
    Kind kind = Kind::kStep;
    uint64_t time_us = 0;
    std::array<float, 4> control{};  // as ActuatorMotors has it
    uint64_t activations = 0;
    uint64_t lost_samples = 0;
    uint64_t missed_samples = 0;  // that a device still busy with the one before did not take
    uint64_t preemptions = 0;
    uint64_t unrecorded_activations = 0;
    uint64_t missed_life_signs = 0;
    uint64_t restarts = 0;  // 1: a restart request ended the flight
};
static_assert(sizeof(ToPlant) == 88);

// What the sensors saw since the step before; of each, the newest sample.
struct FromPlant {
    uint32_t is_over = 0;  // nothing else counts then
    uint32_t imu_sampled = 0;
    uint32_t mocap_received = 0;
    uint32_t mag_sampled = 0;
    uint32_t baro_sampled = 0;
    uint32_t gnss_received = 0;
    uint32_t radio_received = 0;
    uint32_t battery_measured = 0;
    uint64_t now_us = 0;  // of all samples without a time of their own
    uint64_t mocap_time_us = 0;
    uint64_t gnss_time_us = 0;
    double latitude_deg = 0.0;
    double longitude_deg = 0.0;
    double altitude_msl_m = 0.0;
    double altitude_ellipsoid_m = 0.0;
    std::array<float, 3> gyro_B{};            // rad/s
    std::array<float, 3> accel_B{};           // m/s^2
    std::array<float, 3> mocap_position_N{};  // m
    float mocap_yaw = 0.0F;                   // rad
    std::array<float, 3> mag_B{};             // gauss
    float pressure = 0.0F;                    // Pa
    float temperature_degc = 0.0F;
    std::array<float, 3> gnss_velocity_N{};  // m/s
    std::array<float, 3> gnss_errors{};      // horizontal and vertical in m, speed in m/s
    uint32_t satellites = 0;
    std::array<float, 4> sticks{};  // roll, pitch, yaw, throttle; -1 to 1
    uint32_t mode_slot = 0;
    std::array<uint8_t, 4> switches{};  // heard, arm, return, kill; 0 or 1
    std::array<float, 4> battery{};     // V, A, mAh, part that remains
};
static_assert(sizeof(FromPlant) == 216);

}  // namespace stator::link
