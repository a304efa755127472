// A vehicle whose true motion is known, its sensors, and the navigation node that listens to them.
#pragma once

#include <array>
#include <deque>

#include "navigation.hpp"
#include "stator/random.hpp"
#include "stator/testing.hpp"

namespace stator::testing {

// It flies as a quadrotor does: what it feels is thrust along its own axis. Its path is a sum of
// sines, so that velocity and acceleration are exact.
class NavigationRig {
  public:
    using Vector3 = math::Vector3<double>;
    using Turn = math::Quaternion<double>;

    // Sensors.
    Vector3 gyro_bias{0, 0, 0};
    Vector3 accel_bias{0, 0, 0};
    double gyro_density = 0.001;  // of the noise, as the node's parameters have it
    double accel_density = 0.05;
    double gnss_velocity_noise = 0.1;
    double gnss_position_noise = 0.5;
    double baro_noise = 0.3;
    double mag_turn = 0;  // rad, by which the field is turned
    uint64_t gnss_delay_us = 110'000;
    bool has_gnss = true;
    bool has_mag = true;
    bool has_baro = true;
    Vector3 glitch_N{0, 0, 0};  // m
    Vector3 velocity_error_N{0, 0, 0};
    bool is_nowhere = false;  // fixes at 0 deg, 0 deg
    uint64_t fixes_ahead_us = 0;
    bool has_imu = true;
    // Motion: amplitudes of a figure of eight, and how high.
    double amplitude = 0;     // m
    double pulse = 0.8;       // rad/s
    double yaw_rate = 0;      // rad/s
    Vector3 push_N{0, 0, 0};  // m/s^2 that the body feels without moving; for a wrong start
    NavigationParams params;

    explicit NavigationRig(uint64_t seed = 1) : random_(seed) {}

    void run(double seconds) {
        const uint64_t end_us = now_us + static_cast<uint64_t>(seconds * 1e6 + 0.5);
        while (now_us < end_us) step();
    }

    // The newest outputs.
    VehicleLocalPosition position{};
    VehicleAttitude attitude{.q = {1, 0, 0, 0}};
    EstimatorStatus status{};
    EstimatorSensorBias bias{};
    EstimatorInnovations innovations{};
    unsigned attitudes = 0;
    uint64_t now_us = 1'000'000;

    // Errors of the outputs.
    double tilt_error() const {
        const Turn error = error_N();
        return 2 * math::sqrt(math::square(error.x()) + math::square(error.y()));
    }
    double heading_error() const {
        const Turn error = error_N();
        return 2 * math::atan2(error.z(), error.w());
    }
    Vector3 velocity_error() const {
        return Eigen::Vector3f(position.vx, position.vy, position.vz).cast<double>() -
               truth_velocity();
    }
    // The origin of N is where the first fix said.
    Vector3 position_error() const {
        return Eigen::Vector3f(position.x, position.y, position.z).cast<double>() -
               truth_position() + first_fix_error_;
    }

    // One activation with these samples as they are.
    void activate(const SensorGyro& gyro, const SensorAccel& accel, const SensorGps* fix,
                  const SensorBaro* baro, const SensorMag* mag) {
        const SensorGps no_fix{};
        const SensorBaro no_baro{};
        const SensorMag no_mag{};
        apps::navigation::NavigationPorts ports{
            .now = now_us,
            .gyro = Input(gyro),
            .accel = Input(accel),
            .gnss = Input(fix ? *fix : no_fix, fix != nullptr),
            .baro = Input(baro ? *baro : no_baro, baro != nullptr),
            .mag = Input(mag ? *mag : no_mag, mag != nullptr),
            .params = Input(params)};
        Probe attitude_probe(ports.attitude, now_us);
        Probe position_probe(ports.position, now_us);
        Probe innovations_probe(ports.innovations, now_us);
        Probe bias_probe(ports.bias, now_us);
        Probe status_probe(ports.estimator, now_us);
        node_.step(ports);
        attitudes += attitude_probe.count();
        if (attitude_probe.count() != 0) attitude = attitude_probe.newest();
        if (position_probe.count() != 0) position = position_probe.newest();
        if (innovations_probe.count() != 0) innovations = innovations_probe.newest();
        if (bias_probe.count() != 0) bias = bias_probe.newest();
        if (status_probe.count() != 0) status = status_probe.newest();
    }

  private:
    static constexpr uint64_t kPeriod_us = 4000;
    static constexpr double kStart_s = 5;  // still before

    double moving_s(uint64_t at_us) const {
        const double t = static_cast<double>(at_us) * 1e-6 - 1.0 - kStart_s;
        return t > 0 ? t : 0;
    }
    // Eight: x = A (1 - cos wt)^2 / 4 keeps velocity and acceleration continuous at the start.
    Vector3 path(double t, int derivative) const {
        const double w = pulse;
        const auto eight = [w, derivative](double amount, double at, double k) {
            // amount * (3/8 - cos(k w t)/2 + cos(2 k w t)/8): (1 - cos)^2 / 4
            const auto [s1, c1] = math::sincos(k * w * at);
            const auto [s2, c2] = math::sincos(2 * k * w * at);
            const double kw = k * w;
            if (derivative == 0) return amount * (0.375 - c1 / 2 + c2 / 8);
            if (derivative == 1) return amount * kw * (s1 / 2 - s2 / 4);
            return amount * kw * kw * (c1 / 2 - c2 / 2);
        };
        return {eight(amplitude, t, 1.0), eight(amplitude / 2, t, 1.7),
                eight(-amplitude / 4, t, 0.6)};
    }
    Vector3 acceleration(uint64_t at_us) const { return path(moving_s(at_us), 2) + push_N; }
    Vector3 truth_velocity() const { return path(moving_s(now_us), 1); }
    Vector3 truth_position() const { return path(moving_s(now_us), 0); }

    Vector3 force_N(uint64_t at_us) const {
        return acceleration(at_us) - Vector3(0, 0, static_cast<double>(apps::navigation::kGravity));
    }
    Turn truth(uint64_t at_us) const {
        const Vector3 force = force_N(at_us) - push_N;
        const Turn tilt = math::from_two_vectors(Vector3(0, 0, -1), force);
        const double yaw = start_yaw + yaw_rate * moving_s(at_us);
        return tilt * math::from_axis_angle(Vector3(0, 0, 1), yaw);
    }
    Turn error_N() const {
        const auto estimate = math::quaternion(attitude.q).cast<double>();
        return math::shortest(Turn(estimate * truth(now_us).conjugate()));
    }
    Vector3 noise(double sigma) {
        Vector3 result;
        for (int i = 0; i < 3; ++i) result(i) = sigma * random_.gaussian_double();
        return result;
    }
    static std::array<float, 3> to_floats(const Vector3& v) {
        return {static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z())};
    }

    void step() {
        now_us += kPeriod_us;
        const double spread = 1 / math::sqrt(static_cast<double>(kPeriod_us) * 1e-6);
        const Turn turned = truth(now_us - 500).conjugate() * truth(now_us + 500);
        const Vector3 rate = math::to_rotation_vector(turned) / 1e-3;
        const Vector3 force = truth(now_us).conjugate() * force_N(now_us);
        const SensorGyro gyro{.timestamp_sample = now_us,
                              .xyz = to_floats(rate + gyro_bias + noise(gyro_density * spread))};
        const SensorAccel accel{
            .timestamp_sample = now_us,
            .xyz = to_floats(force + accel_bias + noise(accel_density * spread))};
        if (has_gnss && now_us % 200'000 == 0) on_the_way_.push_back(fix_now());
        const bool arrives =
            !on_the_way_.empty() &&
            on_the_way_.front().timestamp_sample + gnss_delay_us <= now_us + fixes_ahead_us;
        const SensorGps fix = arrives ? on_the_way_.front() : SensorGps{};
        if (arrives) on_the_way_.pop_front();
        const SensorBaro baro = baro_now();
        const SensorMag mag = mag_now();
        activate(has_imu ? gyro : last_gyro_, has_imu ? accel : last_accel_,
                 arrives ? &fix : nullptr, has_baro && now_us % 40'000 == 0 ? &baro : nullptr,
                 has_mag && now_us % 40'000 == 0 ? &mag : nullptr);
        if (!has_imu) return;
        last_gyro_ = gyro;
        last_accel_ = accel;
    }

    SensorGps fix_now() {
        const Vector3 error = noise(gnss_position_noise);
        if (is_nowhere)
            return {.timestamp_sample = now_us,
                    .eph = 0.5F,
                    .epv = 2.0F,
                    .fix_type = SensorGps::FixType::kFix3d};
        if (!has_fix_) {
            first_fix_error_ = truth_position() + error;
            first_fix_error_.z() = 0;
        }
        has_fix_ = true;
        const Vector3 at = truth_position() + error + glitch_N;
        const auto place = earth_.from_local({at.x(), at.y()});
        const auto velocity =
            to_floats(truth_velocity() + velocity_error_N + noise(gnss_velocity_noise));
        return {.timestamp_sample = now_us + fixes_ahead_us,
                .latitude_deg = place.latitude_deg,
                .longitude_deg = place.longitude_deg,
                .altitude_msl_m = 500 - at.z(),
                .s_variance_m_s = 0.1F,
                .eph = 0.5F,
                .epv = 2.0F,
                .vel_n_m_s = velocity[0],
                .vel_e_m_s = velocity[1],
                .vel_d_m_s = velocity[2],
                .fix_type = SensorGps::FixType::kFix3d,
                .vel_ned_valid = true,
                .satellites_used = 12};
    }
    SensorBaro baro_now() {
        const double height = 500 - truth_position().z() + baro_noise * random_.gaussian_double();
        const double ratio = 1 - height / 44330.8;
        return {.timestamp_sample = now_us,
                .pressure = static_cast<float>(101325 * math::pow(ratio, 1 / 0.190263))};
    }
    SensorMag mag_now() {
        const Vector3 field_N(0.2, 0, 0.4);
        const Turn turn = math::from_axis_angle(Vector3(0, 0, 1), mag_turn);
        return {.timestamp_sample = now_us,
                .xyz = to_floats(truth(now_us).conjugate() * (turn * field_N))};
    }

  public:
    double start_yaw = 0.6;

  private:
    apps::navigation::Navigation node_;
    math::Random random_;
    math::LocalFrame earth_{{47.4, 8.5}};
    std::deque<SensorGps> on_the_way_;
    SensorGyro last_gyro_{};
    SensorAccel last_accel_{};
    Vector3 first_fix_error_ = Vector3::Zero();
    bool has_fix_ = false;
};

}  // namespace stator::testing
