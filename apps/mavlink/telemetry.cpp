// What the vehicle tells of itself.
#include "telemetry.hpp"

#include <algorithm>
#include <string_view>

#include "flight_modes.hpp"
#include "stator/rotation.hpp"

namespace stator::apps::mavlink {

namespace {

using math::saturate;
using Nav = VehicleStatus::NavState;

constexpr float kDegree = math::kPi<float> / 180.0F;
constexpr float kNan = math::canonical_nan<float>();
constexpr uint16_t kUnknown16 = UINT16_MAX;
constexpr uint32_t kAutoMode = 4;                                    // MAV_MODE_PROPERTY_AUTO_MODE
constexpr std::string_view kGeneralUri = "mftp://etc/general.json";  // as file_source.hpp has it
constexpr double kStandardPressure = 101325.0;                       // Pa

bool is_armed(const MavlinkPorts& ports) {
    return ports.status && ports.status->arming_state == VehicleStatus::ArmingState::kArmed;
}

// By a command. What a mission lacks counts only where it would be flown.
bool may_be_armed(const MavlinkPorts& ports) {
    if (is_armed(ports)) return true;
    if (!ports.health || !ports.status) return false;
    const HealthReport& h = *ports.health;
    const bool flies_mission = ports.status->nav_state == Nav::kMission;
    return h.sensors_ok && h.estimator_ok && h.battery_ok && h.motors_ok && h.rc_ok &&
           h.logging_ok && h.parameters_ok && (h.mission_ok || !flies_mission);
}

int32_t degrees_e7(double degrees) {
    return saturate<int32_t>(math::round(degrees * 1e7));
}
int32_t millimetres(float metres) {
    return saturate<int32_t>(math::round(metres * 1000.0F));
}
int16_t centi(float value) {
    return saturate<int16_t>(math::round(value * 100.0F));
}
// 0 to 360 deg, in hundredths.
uint16_t heading_cdeg(float heading) {
    const float degrees = math::wrap_pi(heading) / kDegree;
    const float positive = degrees < 0.0F ? degrees + 360.0F : degrees;
    return static_cast<uint16_t>(saturate<uint16_t>(math::round(positive * 100.0F)) % 36000U);
}
// Of an error that may not be known.
uint32_t error_mm(float metres) {
    return math::is_finite(metres) ? saturate<uint32_t>(metres * 1000.0F) : 0;
}

template <class Message>
Told sent(Link& link, const Message& message) {
    return link.send(message) ? Told::kSent : Told::kNoRoom;
}

math::EulerAngles<float> euler_of(const VehicleAttitude& attitude) {
    return math::to_euler(math::quaternion(attitude.q));
}

mav::GpsRawInt gps_raw(const SensorGps& fix) {
    const float north = fix.vel_n_m_s;
    const float east = fix.vel_e_m_s;
    const float speed = math::sqrt(north * north + east * east);
    mav::GpsRawInt message{.time_usec = fix.timestamp_sample,
                           .lat = degrees_e7(fix.latitude_deg),
                           .lon = degrees_e7(fix.longitude_deg),
                           .alt = saturate<int32_t>(math::round(fix.altitude_msl_m * 1000.0)),
                           .eph = kUnknown16,
                           .epv = kUnknown16,
                           .vel = kUnknown16,
                           .cog = kUnknown16,
                           .fix_type = static_cast<uint8_t>(fix.fix_type),
                           .satellites_visible = fix.satellites_used};
    if (fix.vel_ned_valid && math::is_finite(speed)) {
        message.vel = saturate<uint16_t>(speed * 100.0F);
        message.cog = heading_cdeg(math::atan2(east, north));
    }
    message.alt_ellipsoid = saturate<int32_t>(math::round(fix.altitude_ellipsoid_m * 1000.0));
    message.h_acc = error_mm(fix.eph);
    message.v_acc = error_mm(fix.epv);
    message.vel_acc = error_mm(fix.s_variance_m_s);
    return message;
}

mav::BatteryStatus battery(const BatteryStatus& status) {
    mav::BatteryStatus message{.current_consumed = saturate<int32_t>(status.discharged_mah),
                               .energy_consumed = -1,
                               .temperature = INT16_MAX,
                               .current_battery = centi(status.current_a)};
    message.voltages.fill(kUnknown16);
    message.voltages[0] = saturate<uint16_t>(status.voltage_v * 1000.0F);
    message.battery_remaining = saturate<int8_t>(math::round(status.remaining * 100.0F));
    message.charge_state = static_cast<uint8_t>(static_cast<uint8_t>(status.warning) + 1);
    return message;
}

// As a receiver of 1000 to 2000 us would have them. The radio's driver has no raw ones.
mav::RcChannels rc_channels(const MavlinkPorts& ports) {
    const auto stick = [](float value) {
        return math::saturate<uint16_t>(1500.0F + 500.0F * math::clamp(value, -1.0F, 1.0F));
    };
    const ManualControlSetpoint& sticks = *ports.radio;
    mav::RcChannels message{.time_boot_ms = static_cast<uint32_t>(ports.now / 1000),
                            .chan1_raw = stick(sticks.roll),
                            .chan2_raw = stick(sticks.pitch),
                            .chan3_raw = stick(sticks.throttle),
                            .chan4_raw = stick(sticks.yaw),
                            .chan5_raw = kUnknown16,
                            .chan6_raw = kUnknown16,
                            .chan7_raw = kUnknown16,
                            .chan8_raw = kUnknown16,
                            .chan9_raw = kUnknown16,
                            .chan10_raw = kUnknown16,
                            .chan11_raw = kUnknown16,
                            .chan12_raw = kUnknown16,
                            .chan13_raw = kUnknown16,
                            .chan14_raw = kUnknown16,
                            .chan15_raw = kUnknown16,
                            .chan16_raw = kUnknown16,
                            .chan17_raw = kUnknown16,
                            .chan18_raw = kUnknown16,
                            .chancount = 4,
                            .rssi = static_cast<uint8_t>(sticks.valid ? 254 : 0)};
    if (ports.switches) {
        using Switch = ManualControlSwitches;
        const Switch& s = *ports.switches;
        const auto on = [](bool is_on) -> uint16_t { return is_on ? 2000 : 1000; };
        message.chan5_raw = static_cast<uint16_t>(900 + 165 * std::clamp<int>(s.mode_slot, 1, 6));
        message.chan6_raw = on(s.arm_switch == Switch::ArmSwitch::kOn);
        message.chan7_raw = on(s.return_switch == Switch::ReturnSwitch::kOn);
        message.chan8_raw = on(s.kill_switch == Switch::KillSwitch::kOn);
        message.chancount = 8;
    }
    return message;
}

mav::LocalPositionNed local_position(const VehicleLocalPosition& p, uint32_t boot_ms) {
    return {
        .time_boot_ms = boot_ms, .x = p.x, .y = p.y, .z = p.z, .vx = p.vx, .vy = p.vy, .vz = p.vz};
}

mav::ExtendedSysState extended_state(const MavlinkPorts& ports) {
    mav::ExtendedSysState message{};
    if (!ports.land) return message;
    const Nav mode = ports.status ? ports.status->nav_state : Nav::kHold;
    uint32_t landed = mav::mav_landed_state::kInAir;
    if (mode == Nav::kTakeoff) landed = mav::mav_landed_state::kTakeoff;
    if (mode == Nav::kLand || mode == Nav::kDescend) landed = mav::mav_landed_state::kLanding;
    if (ports.land->landed) landed = mav::mav_landed_state::kOnGround;
    message.landed_state = static_cast<uint8_t>(landed);
    return message;
}

}  // namespace

void Telemetry::update(const MavlinkPorts& ports) {
    if (ports.position && ports.position->xy_global) {
        const VehicleLocalPosition& p = *ports.position;
        const bool is_other = !knows_earth_ || p.ref_lat != frame_.origin().latitude_deg ||
                              p.ref_lon != frame_.origin().longitude_deg;
        if (is_other) frame_ = math::LocalFrame({p.ref_lat, p.ref_lon});
        reference_altitude_ = p.ref_alt;
        knows_earth_ = true;
        if (!is_armed(ports) && p.xy_valid && p.z_valid) {
            home_N_ = {p.x, p.y, p.z};
            home_heading_ = p.heading;
            knows_home_ = true;
        }
    }
    if (is_armed(ports) && ports.home && ports.home->valid_lpos) {
        home_N_ = {ports.home->x, ports.home->y, ports.home->z};
        home_heading_ = ports.home->yaw;
    }
    update_mission(ports);
    uint32_t status = 0;
    if (ports.status) {
        const VehicleStatus& s = *ports.status;
        status = static_cast<uint32_t>(s.arming_state) << 16 |
                 static_cast<uint32_t>(s.nav_state) << 8 | (s.failsafe ? 1U : 0U);
    }
    is_status_new_ = status != told_status_;
    told_status_ = status;
}

mav::Heartbeat Telemetry::heartbeat(const MavlinkPorts& ports) const {
    mav::Heartbeat message{.type = mav::mav_type::kQuadrotor,
                           .autopilot = mav::mav_autopilot::kPx4,
                           .base_mode = mav::mav_mode_flag::kCustomModeEnabled,
                           .system_status = mav::mav_state::kBoot,
                           .mavlink_version = 3};
    if (!ports.status) return message;
    const VehicleStatus& status = *ports.status;
    const FlightMode& mode = mode_of(status.nav_state);
    message.custom_mode = custom_mode(mode);
    uint32_t flags = mav::mav_mode_flag::kCustomModeEnabled;
    if (is_armed(ports)) flags |= mav::mav_mode_flag::kSafetyArmed;
    if (mode.is_manual) flags |= mav::mav_mode_flag::kManualInputEnabled;
    if (status.nav_state != Nav::kManual) flags |= mav::mav_mode_flag::kStabilizeEnabled;
    if (!mode.is_manual)
        flags |= mav::mav_mode_flag::kGuidedEnabled | mav::mav_mode_flag::kAutoEnabled;
    message.base_mode = static_cast<uint8_t>(flags);
    uint32_t state = is_armed(ports) ? mav::mav_state::kActive : mav::mav_state::kStandby;
    if (status.failsafe) state = mav::mav_state::kCritical;
    if (status.nav_state == Nav::kTermination) state = mav::mav_state::kFlightTermination;
    message.system_status = static_cast<uint8_t>(state);
    return message;
}

mav::SysStatus Telemetry::sys_status(const MavlinkPorts& ports) const {
    namespace sensor = mav::mav_sys_status_sensor;
    uint32_t present = sensor::kSensor3dGyro | sensor::kSensor3dAccel | sensor::kSensorMotorOutputs;
    uint32_t health = sensor::kSensorMotorOutputs;
    const auto add = [&](uint32_t bit, bool is_there, bool is_good) {
        if (is_there) present |= bit;
        if (is_there && is_good) health |= bit;
    };
    add(sensor::kSensor3dGyro, true, static_cast<bool>(ports.gyro));
    add(sensor::kSensor3dAccel, true, static_cast<bool>(ports.accel));
    add(sensor::kSensor3dMag, true, static_cast<bool>(ports.mag));
    add(sensor::kSensorAbsolutePressure, true, static_cast<bool>(ports.baro));
    const bool has_position = ports.position && ports.position->xy_valid && ports.position->z_valid;
    add(sensor::kSensorGps, true, ports.gnss && ports.gnss->fix_type >= SensorGps::FixType::kFix3d);
    add(sensor::kAhrs, true, ports.attitude && has_position);
    add(sensor::kSensorRcReceiver, static_cast<bool>(ports.sticks),
        ports.sticks && ports.sticks->valid);
    const bool is_inside = ports.fence && !ports.fence->geofence_max_dist_triggered &&
                           !ports.fence->geofence_max_alt_triggered &&
                           !ports.fence->geofence_custom_fence_triggered;
    add(sensor::kGeofence, true, is_inside || !ports.fence);
    if (ports.health) {
        add(sensor::kLogging, true, ports.health->logging_ok);
        add(sensor::kSensorBattery, true, ports.health->battery_ok);
        add(sensor::kPrearmCheck, true, may_be_armed(ports));
    }
    mav::SysStatus message{.onboard_control_sensors_present = present,
                           .onboard_control_sensors_enabled = present,
                           .onboard_control_sensors_health = health,
                           .voltage_battery = kUnknown16,
                           .current_battery = -1};
    message.battery_remaining = -1;
    if (ports.battery && ports.battery->connected) {
        message.voltage_battery = saturate<uint16_t>(ports.battery->voltage_v * 1000.0F);
        message.current_battery = centi(ports.battery->current_a);
        message.battery_remaining =
            saturate<int8_t>(math::round(ports.battery->remaining * 100.0F));
    }
    return message;
}

mav::GlobalPositionInt Telemetry::global_position(const VehicleLocalPosition& p,
                                                  uint32_t boot_ms) const {
    const auto place = frame_.from_local({static_cast<double>(p.x), static_cast<double>(p.y)});
    return {.time_boot_ms = boot_ms,
            .lat = degrees_e7(place.latitude_deg),
            .lon = degrees_e7(place.longitude_deg),
            .alt = millimetres(reference_altitude_ - p.z),
            .relative_alt = millimetres(home_N_[2] - p.z),
            .vx = centi(p.vx),
            .vy = centi(p.vy),
            .vz = centi(p.vz),
            .hdg = heading_cdeg(p.heading)};
}

mav::HomePosition Telemetry::home_position(uint64_t now_us) const {
    const auto place =
        frame_.from_local({static_cast<double>(home_N_[0]), static_cast<double>(home_N_[1])});
    const math::Quaternion<float> q =
        math::from_euler(math::EulerAngles<float>{0.0F, 0.0F, home_heading_});
    mav::HomePosition message{.latitude = degrees_e7(place.latitude_deg),
                              .longitude = degrees_e7(place.longitude_deg),
                              .altitude = millimetres(reference_altitude_ - home_N_[2]),
                              .x = home_N_[0],
                              .y = home_N_[1],
                              .z = home_N_[2],
                              .q = {q.w(), q.x(), q.y(), q.z()},
                              .approach_x = kNan,
                              .approach_y = kNan,
                              .approach_z = kNan};
    message.time_usec = now_us;
    return message;
}

// A mission is complete from its end on, until it is flown again or another one takes its place.
void Telemetry::update_mission(const MavlinkPorts& ports) {
    mav::MissionCurrent message{};
    const bool has_mission = ports.mission && ports.mission->count != 0;
    if (ports.mission) {
        message.total = ports.mission->count;
        message.mission_id = ports.mission->mission_id;
        message.fence_id = ports.mission->geofence_id;
        message.rally_points_id = ports.mission->safe_points_id;
    }
    const bool flies_mission = is_armed(ports) && ports.status->nav_state == Nav::kMission;
    uint32_t state = has_mission ? mav::mission_state::kNotStarted : mav::mission_state::kNoMission;
    if (ports.result && has_mission) {
        const MissionResult& result = *ports.result;
        message.seq = result.seq_current;
        const bool is_of_mission = result.nav_state == static_cast<uint8_t>(Nav::kMission);
        const bool is_over = (is_of_mission && result.finished) || result.waits;
        if (message.mission_id != mission_.mission_id) is_complete_ = false;
        if (flies_mission || is_over) is_complete_ = is_over;
        if (is_complete_) {
            state = mav::mission_state::kComplete;
        } else if (flies_mission) {
            state = mav::mission_state::kActive;
        } else if (is_armed(ports) && result.seq_reached >= 0) {
            state = mav::mission_state::kPaused;
        }
    }
    message.mission_state = static_cast<uint8_t>(state);
    message.mission_mode = flies_mission ? 1 : 2;
    is_mission_new_ = !(message == mission_);
    mission_ = message;
}

mav::Odometry Telemetry::odometry(const MavlinkPorts& ports) const {
    const VehicleLocalPosition& p = *ports.position;
    const math::Vector3<float> v_N(p.vx, p.vy, p.vz);
    const math::Vector3<float> v_B =
        math::quaternion(ports.attitude->q).conjugate().toRotationMatrix() * v_N;
    mav::Odometry message{.time_usec = p.timestamp_sample,
                          .x = p.x,
                          .y = p.y,
                          .z = p.z,
                          .q = ports.attitude->q,
                          .vx = v_B.x(),
                          .vy = v_B.y(),
                          .vz = v_B.z()};
    if (ports.gyro) {
        message.rollspeed = ports.gyro->xyz[0];
        message.pitchspeed = ports.gyro->xyz[1];
        message.yawspeed = ports.gyro->xyz[2];
    }
    message.pose_covariance.fill(kNan);
    message.velocity_covariance.fill(kNan);
    message.frame_id = mav::mav_frame::kLocalNed;
    message.child_frame_id = 12;  // MAV_FRAME_BODY_FRD
    return message;
}

Told Telemetry::tell_position(uint32_t id, Link& link, const MavlinkPorts& ports) const {
    if (!ports.position) return Told::kNothing;
    const VehicleLocalPosition& p = *ports.position;
    const auto boot_ms = static_cast<uint32_t>(ports.now / 1000);
    switch (id) {
        case mav::LocalPositionNed::kId:
            return p.xy_valid ? sent(link, local_position(p, boot_ms)) : Told::kNothing;
        case mav::GlobalPositionInt::kId:
            return knows_earth_ ? sent(link, global_position(p, boot_ms)) : Told::kNothing;
        case mav::Altitude::kId:
            return sent(link, mav::Altitude{.time_usec = ports.now,
                                            .altitude_monotonic = reference_altitude_ - p.z,
                                            .altitude_amsl = reference_altitude_ - p.z,
                                            .altitude_local = -p.z,
                                            .altitude_relative = home_N_[2] - p.z,
                                            .altitude_terrain = kNan,
                                            .bottom_clearance = kNan});
        case mav::Odometry::kId:
            return ports.attitude ? sent(link, odometry(ports)) : Told::kNothing;
        default:
            return Told::kUnknown;
    }
}

Told Telemetry::tell_attitude(uint32_t id, Link& link, const MavlinkPorts& ports) const {
    if (!ports.attitude) return Told::kNothing;
    const auto boot_ms = static_cast<uint32_t>(ports.now / 1000);
    const std::array<float, 3> rates = ports.gyro ? ports.gyro->xyz : std::array<float, 3>{};
    if (id == mav::Attitude::kId) {
        const auto angles = euler_of(*ports.attitude);
        return sent(link, mav::Attitude{.time_boot_ms = boot_ms,
                                        .roll = angles.roll,
                                        .pitch = angles.pitch,
                                        .yaw = angles.yaw,
                                        .rollspeed = rates[0],
                                        .pitchspeed = rates[1],
                                        .yawspeed = rates[2]});
    }
    const auto& q = ports.attitude->q;
    return sent(link, mav::AttitudeQuaternion{.time_boot_ms = boot_ms,
                                              .q1 = q[0],
                                              .q2 = q[1],
                                              .q3 = q[2],
                                              .q4 = q[3],
                                              .rollspeed = rates[0],
                                              .pitchspeed = rates[1],
                                              .yawspeed = rates[2]});
}

Told Telemetry::tell_sensors(uint32_t id, Link& link, const MavlinkPorts& ports) const {
    switch (id) {
        case mav::GpsRawInt::kId:
            return ports.gnss ? sent(link, gps_raw(*ports.gnss)) : Told::kNothing;
        case mav::BatteryStatus::kId:
            return ports.battery ? sent(link, battery(*ports.battery)) : Told::kNothing;
        default:
            break;
    }
    if (!ports.gyro || !ports.accel) return Told::kNothing;
    mav::HighresImu message{.time_usec = ports.gyro->timestamp_sample,
                            .xacc = ports.accel->xyz[0],
                            .yacc = ports.accel->xyz[1],
                            .zacc = ports.accel->xyz[2],
                            .xgyro = ports.gyro->xyz[0],
                            .ygyro = ports.gyro->xyz[1],
                            .zgyro = ports.gyro->xyz[2],
                            .fields_updated = 0x3F};
    if (ports.mag) {
        message.xmag = ports.mag->xyz[0];
        message.ymag = ports.mag->xyz[1];
        message.zmag = ports.mag->xyz[2];
        message.fields_updated = 0x1FF;
    }
    if (ports.baro) {
        message.abs_pressure = ports.baro->pressure * 0.01F;  // hPa
        message.temperature = ports.baro->temperature;
        message.fields_updated = static_cast<uint16_t>(message.fields_updated | 0x1200U);
    }
    return sent(link, message);
}

void Telemetry::tell_mode(unsigned number, Link& link) {
    const FlightMode& mode = mode_to_choose(number);
    mav::AvailableModes message{.custom_mode = custom_mode(mode),
                                .properties = mode.is_manual ? 0U : kAutoMode,
                                .number_modes = kModesToChoose,
                                .mode_index = static_cast<uint8_t>(number + 1),
                                .standard_mode = mode.standard};
    const std::string_view name = mode.name;
    std::ranges::copy(name, message.mode_name.begin());
    link.send(message);
}

// Of a circle in hold: one in a mission is the mission's.
Told Telemetry::tell_orbit(Link& link, const MavlinkPorts& ports) const {
    const bool flies_one = ports.goal && ports.goal->kind == GotoSetpoint::Kind::kCircle &&
                           ports.status && is_armed(ports) &&
                           ports.status->nav_state == VehicleStatus::NavState::kHold;
    if (!flies_one || !knows_earth_) return Told::kNothing;
    const auto& centre_N = ports.goal->position;
    const auto at =
        frame_.from_local({static_cast<double>(centre_N[0]), static_cast<double>(centre_N[1])});
    return sent(link,
                mav::OrbitExecutionStatus{
                    .time_usec = ports.now,
                    .radius = ports.goal->laps < 0.0F ? -ports.goal->length : ports.goal->length,
                    .x = degrees_e7(at.latitude_deg),
                    .y = degrees_e7(at.longitude_deg),
                    .z = reference_altitude_ - centre_N[2],
                    .frame = mav::mav_frame::kGlobal});
}

Told Telemetry::tell_status(uint32_t id, Link& link, const MavlinkPorts& ports) const {
    switch (id) {
        case mav::Heartbeat::kId:
            return sent(link, heartbeat(ports));
        case mav::SysStatus::kId:
            return sent(link, sys_status(ports));
        case mav::ExtendedSysState::kId:
            return sent(link, extended_state(ports));
        case mav::SystemTime::kId:
            return sent(link,
                        mav::SystemTime{.time_boot_ms = static_cast<uint32_t>(ports.now / 1000)});
        case mav::HomePosition::kId:
            return knows_home_ ? sent(link, home_position(ports.now)) : Told::kNothing;
        case mav::MissionCurrent::kId:
            return sent(link, mission_);
        case mav::CurrentMode::kId: {
            if (!ports.status) return Told::kNothing;
            const FlightMode& mode = mode_of(ports.status->nav_state);
            return sent(link, mav::CurrentMode{.custom_mode = custom_mode(mode),
                                               .standard_mode = mode.standard});
        }
        default:
            return Told::kUnknown;
    }
}

Told Telemetry::tell(uint32_t id, Link& link, const MavlinkPorts& ports) const {
    switch (id) {
        case mav::LocalPositionNed::kId:
        case mav::GlobalPositionInt::kId:
        case mav::Altitude::kId:
        case mav::Odometry::kId:
            return tell_position(id, link, ports);
        case mav::Attitude::kId:
        case mav::AttitudeQuaternion::kId:
            return tell_attitude(id, link, ports);
        case mav::GpsRawInt::kId:
        case mav::BatteryStatus::kId:
        case mav::HighresImu::kId:
            return tell_sensors(id, link, ports);
        case mav::RcChannels::kId:
            return ports.radio ? sent(link, rc_channels(ports)) : Told::kNothing;
        case mav::OrbitExecutionStatus::kId:
            return tell_orbit(link, ports);
        case mav::VfrHud::kId: {
            if (!ports.position) return Told::kNothing;
            const VehicleLocalPosition& p = *ports.position;
            const float speed = math::sqrt(p.vx * p.vx + p.vy * p.vy);
            return sent(
                link, mav::VfrHud{.airspeed = speed,
                                  .groundspeed = speed,
                                  .alt = reference_altitude_ - p.z,
                                  .climb = -p.vz,
                                  .heading = static_cast<int16_t>(heading_cdeg(p.heading) / 100)});
        }
        case mav::AutopilotVersion::kId: {
            namespace can = mav::mav_protocol_capability;
            return sent(link,
                        mav::AutopilotVersion{
                            .capabilities = can::kMissionInt | can::kCommandInt | can::kMavlink2 |
                                            can::kParamEncodeBytewise | can::kMissionFence |
                                            can::kMissionRally | can::kSetAttitudeTarget |
                                            can::kSetPositionTargetLocalNed |
                                            can::kSetPositionTargetGlobalInt | can::kFtp,
                            .uid = 1,
                            .flight_sw_version = 0x010000FF});
        }
        case mav::ComponentMetadata::kId: {
            if (ports.metadata == nullptr) return Told::kUnknown;
            mav::ComponentMetadata message{.time_boot_ms = static_cast<uint32_t>(ports.now / 1000),
                                           .file_crc = ports.metadata->general.crc};
            std::ranges::copy(kGeneralUri, message.uri.begin());
            return sent(link, message);
        }
        default:
            return tell_status(id, link, ports);
    }
}

}  // namespace stator::apps::mavlink
