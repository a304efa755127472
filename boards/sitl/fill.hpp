// From what the simulated world measures to the devices that drivers see.
#pragma once

#include "drivers/baro/sim/baro_sim.hpp"
#include "drivers/battery/sim/battery_sim.hpp"
#include "drivers/gnss/sim/gnss_sim.hpp"
#include "drivers/radio/sim/radio_sim.hpp"
#include "world.hpp"

namespace stator::board {

inline void fill(drivers::baro::sim::BaroSim::Device& device, const BarometerSample& sample, std::uint64_t now_us) {
    device = {.timestamp_sample = now_us,
              .samples = device.samples + 1,
              .pressure = sample.pressure,
              .temperature_degc = sample.temperature_degc};
}

inline void fill(drivers::gnss::sim::GnssSim::Device& device, const GnssFix& fix) {
    device = {.timestamp_sample = fix.time_us,
              .latitude_deg = fix.place.latitude_deg,
              .longitude_deg = fix.place.longitude_deg,
              .altitude_msl_m = fix.place.altitude_msl,
              .altitude_ellipsoid_m = fix.place.altitude_ellipsoid,
              .velocity_N = math::to_array(fix.velocity_N),
              .horizontal_error = fix.horizontal_error,
              .vertical_error = fix.vertical_error,
              .speed_error = fix.speed_error,
              .satellites = fix.satellites};
}

inline void fill(drivers::radio::sim::RadioSim::Device& device, const World::RadioFrame& frame, std::uint64_t now_us) {
    device = {.timestamp_sample = now_us,
              .roll = frame.hands.roll,
              .pitch = frame.hands.pitch,
              .yaw = frame.hands.yaw,
              .throttle = frame.hands.throttle,
              .mode_slot = frame.hands.mode_slot,
              .is_heard = frame.is_heard,
              .arm = frame.hands.arm,
              .return_home = frame.hands.return_home,
              .kill = frame.hands.kill};
}

inline void fill(drivers::battery::sim::BatterySim::Device& device, const Battery& battery) {
    constexpr double kMilliampHours = 1.0 / 3.6;  // in a coulomb
    device = {.voltage_v = static_cast<float>(battery.voltage()),
              .current_a = static_cast<float>(battery.current()),
              .discharged_mah = static_cast<float>(kMilliampHours * battery.discharged_c()),
              .remaining = static_cast<float>(battery.remaining())};
}

}  // namespace stator::board
