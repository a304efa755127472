// The satellite receiver of a simulated board.
#include "gnss_sim.hpp"

namespace stator::drivers::gnss::sim {

void GnssSim::step(GnssPorts& ports) {
    if (!ports.fired.received) return;
    constexpr uint32_t kSatellitesOfFix = 4;  // three coordinates and the clock
    const Device fix = device_;
    const bool has_fix = fix.satellites >= kSatellitesOfFix;
    ports.position.publish([&] {
        return SensorGps{
            .timestamp_sample = fix.timestamp_sample,
            .latitude_deg = fix.latitude_deg,
            .longitude_deg = fix.longitude_deg,
            .altitude_msl_m = fix.altitude_msl_m,
            .altitude_ellipsoid_m = fix.altitude_ellipsoid_m,
            .s_variance_m_s = fix.speed_error,
            .eph = fix.horizontal_error,
            .epv = fix.vertical_error,
            .vel_n_m_s = fix.velocity_N[0],
            .vel_e_m_s = fix.velocity_N[1],
            .vel_d_m_s = fix.velocity_N[2],
            .fix_type = has_fix ? SensorGps::FixType::kFix3d : SensorGps::FixType::kNone,
            .vel_ned_valid = has_fix,
            .satellites_used = static_cast<uint8_t>(fix.satellites)};
    });
}

}  // namespace stator::drivers::gnss::sim
