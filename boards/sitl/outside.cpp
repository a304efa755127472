// The world of another simulator, as its messages show it.
#include "outside.hpp"

#include <algorithm>
#include <cinttypes>
#include <cstdio>

#include "world/battery.hpp"
#include "world/ending.hpp"

namespace stator::board {

namespace {

// A simulator that was paused has waited. One that jumps so far has changed its clock.
constexpr std::uint64_t kMostStep_us = 60'000'000;
// How long before it arrives a fix may have been true. A time that is further away is of another
// clock, as simulators send it that have the time of day there.
constexpr std::uint64_t kOldestFix_us = 500'000;

template <class... Arguments>
std::string text(const char* form, Arguments... arguments) {
    std::array<char, 200> line;
    std::snprintf(line.data(), line.size(), form, arguments...);
    return line.data();
}

bool has(const mav::HilSensor& sensor, std::uint32_t bits) {
    return (sensor.fields_updated & bits) == bits;
}

bool are_finite(std::initializer_list<float> values) {
    return std::all_of(values.begin(), values.end(), math::is_finite<float>);
}

}  // namespace

Outside::Outside(const world::Conditions& conditions, const world::Vehicle& vehicle)
    : conditions_(conditions), vehicle_(vehicle) {
    control_.fill(math::canonical_nan<float>());
}

// Some simulators wait for a sign of life before they send anything.
std::string Outside::connect(const char* place) {
    std::string wrong = link_.connect(place);
    if (wrong.empty()) send_heartbeat();
    return wrong;
}

std::uint8_t Outside::mode() const {
    using namespace mav::mav_mode_flag;
    return static_cast<std::uint8_t>(kCustomModeEnabled | (motors_are_stopped_ ? 0 : kSafetyArmed));
}

void Outside::send_heartbeat() {
    const std::uint32_t state =
        motors_are_stopped_ ? mav::mav_state::kStandby : mav::mav_state::kActive;
    link_.send(mav::Heartbeat{.type = static_cast<std::uint8_t>(mav::mav_type::kQuadrotor),
                              .autopilot = static_cast<std::uint8_t>(mav::mav_autopilot::kPx4),
                              .base_mode = mode(),
                              .system_status = static_cast<std::uint8_t>(state),
                              .mavlink_version = 3});
}

void Outside::end(std::string problem) {
    if (world::ending_signal.load() == 0) problem_ = std::move(problem);
    has_sensor_ = false;
}

std::uint64_t Outside::next_event_us(std::uint64_t now_us) {
    if (has_sensor_ && is_taken_) answer();
    while (!has_sensor_ && problem_.empty()) {
        const auto frame = link_.next();
        if (!frame) {
            end(text("the simulator closed the connection at %.3f s",
                     static_cast<double>(time_us_) * 1e-6));
            return now_us;
        }
        if (frame->id == mav::HilGps::kId) {
            const auto fix = mav::decode<mav::HilGps>(frame->payload);
            if (fix.id != 0) continue;  // of a second receiver
            fix_ = fix;
            has_fix_ = true;
        } else if (frame->id == mav::HilSensor::kId) {
            const auto sensor = mav::decode<mav::HilSensor>(frame->payload);
            if (sensor.id == 0 && !accept(sensor)) return now_us;  // others are second sensors
        }
    }
    return problem_.empty() ? time_us_ : now_us;
}

bool Outside::accept(const mav::HilSensor& sensor) {
    if (is_first_) first_us_ = sensor.time_usec;
    is_first_ = false;
    const std::uint64_t newest_us = first_us_ + time_us_;
    if (sensor.time_usec < newest_us || sensor.time_usec - newest_us > kMostStep_us) {
        end(text("HIL_SENSOR.time_usec: expected %" PRIu64
                 " us, or at most 60 s more, found %" PRIu64 " us",
                 newest_us, sensor.time_usec));
        return false;
    }
    time_us_ = sensor.time_usec - first_us_;
    sensor_ = sensor;
    has_sensor_ = true;
    is_taken_ = false;
    return true;
}

void Outside::answer() {
    if (heartbeat_timer_.take(time_us_)) send_heartbeat();
    mav::HilActuatorControls controls{
        .time_usec = sensor_.time_usec, .flags = hil::kLockstep, .mode = mode()};
    for (unsigned i = 0; i < control_.size(); ++i) {
        if (!math::is_nan(control_[i])) controls.controls[i] = control_[i];
    }
    link_.send(controls);
    has_sensor_ = false;
}

void Outside::take(Samples& samples) {
    if (!has_sensor_) return;
    take_sensor(samples);
    take_fix(samples);
    take_parts(samples);
    is_taken_ = true;
}

void Outside::take_sensor(Samples& samples) {
    const mav::HilSensor& s = sensor_;
    const std::array accel{s.xacc, s.yacc, s.zacc};
    const std::array gyro{s.xgyro, s.ygyro, s.zgyro};
    const bool is_whole = has(s, hil::kGyro | hil::kAccel);
    if (is_whole && are_finite({s.xacc, s.yacc, s.zacc, s.xgyro, s.ygyro, s.zgyro})) {
        samples.imu0 = {1, {.timestamp_sample = time_us_, .gyro_B = gyro, .accel_B = accel}};
    }
    if (has(s, hil::kMag) && are_finite({s.xmag, s.ymag, s.zmag})) {
        samples.mag0 = {1,
                        {.timestamp_sample = time_us_, .field_B_gauss = {s.xmag, s.ymag, s.zmag}}};
    }
    if (has(s, hil::kBaro) && are_finite({s.abs_pressure, s.temperature})) {
        constexpr float kPascals = 100.0F;  // in a hectopascal
        samples.baro0 = {1,
                         {.timestamp_sample = time_us_,
                          .pressure = kPascals * s.abs_pressure,
                          .temperature_degc = s.temperature}};
    }
}

void Outside::take_fix(Samples& samples) {
    if (!has_fix_) return;
    has_fix_ = false;
    constexpr std::uint8_t kFix3d = 3;
    constexpr std::uint8_t kUnknownCount = 255;
    constexpr std::uint32_t kUsualCount = 10;
    constexpr float kMetres = 0.01F;      // in a centimetre
    constexpr float kSpeedError = 0.25F;  // m/s; the message does not say
    const std::uint64_t at_us = fix_.time_usec - first_us_;
    const bool is_own_clock = at_us <= time_us_ && time_us_ - at_us <= kOldestFix_us;
    const std::uint32_t satellites =
        fix_.satellites_visible == kUnknownCount ? kUsualCount : fix_.satellites_visible;
    const double altitude = 1e-3 * fix_.alt;
    samples.gnss0 = {1,
                     {.timestamp_sample = is_own_clock ? at_us : time_us_,
                      .latitude_deg = 1e-7 * fix_.lat,
                      .longitude_deg = 1e-7 * fix_.lon,
                      .altitude_msl_m = altitude,
                      .altitude_ellipsoid_m = altitude,
                      .velocity_N = {kMetres * fix_.vn, kMetres * fix_.ve, kMetres * fix_.vd},
                      .horizontal_error = kMetres * fix_.eph,
                      .vertical_error = kMetres * fix_.epv,
                      .speed_error = kSpeedError,
                      .satellites = fix_.fix_type < kFix3d ? 0 : satellites}};
}

// What no message brings: a radio in the hands of the pilot, and a battery that stays full.
void Outside::take_parts(Samples& samples) {
    if (radio_timer_.take(time_us_)) {
        const world::PilotFrame& hands = conditions_.pilot.frame(time_us_);
        samples.radio0 = {1,
                          {.timestamp_sample = time_us_,
                           .roll = hands.roll,
                           .pitch = hands.pitch,
                           .yaw = hands.yaw,
                           .throttle = hands.throttle,
                           .mode_slot = hands.mode_slot,
                           .is_heard = true,
                           .arm = hands.arm,
                           .return_home = hands.return_home,
                           .kill = hands.kill}};
    }
    if (battery_timer_.take(time_us_)) {
        const world::Battery full{vehicle_.battery};
        samples.battery0 = {1,
                            {.voltage_v = static_cast<float>(full.voltage()), .remaining = 1.0F}};
    }
}

void Outside::command_motors(const Control& control) {
    control_ = control;
    const bool were_stopped = motors_are_stopped_;
    motors_are_stopped_ = std::all_of(control.begin(), control.end(), math::is_nan<float>);
    motors_have_run_ = motors_have_run_ || !motors_are_stopped_;
    if (motors_are_stopped_ && !were_stopped) stopped_us_ = time_us_;
}

bool Outside::is_over() const {
    return !conditions_.is_endless && motors_have_run_ && motors_are_stopped_ &&
           time_us_ - stopped_us_ >= world::kStandstill_us;
}

}  // namespace stator::board
