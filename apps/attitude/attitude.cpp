// Attitude estimation: what each sensor's sample does.
#include "attitude.hpp"

namespace stator::apps::attitude {

namespace {

// A gap longer than this breaks the integration: gravity is found again, as at the start.
constexpr float kLongestGap = 0.25F;  // s
// Corrections are slow: the samples of this long are averaged first.
constexpr uint64_t kCorrectionInterval = 10'000;  // us
// Motion capture that was away for longer is followed at once, as at the start, whatever turned in
// the meantime: the vehicle or its reference.
constexpr float kLongestCaptureGap = 1.0F;    // s
constexpr uint64_t kCaptureHold = 1'000'000;  // us
constexpr float kMoving = 0.35F;              // rad/s
// Nearer to the vertical the nose shows no heading.
constexpr float kMinLevelNose = 0.2F;

bool is_finite(const math::Vector3<float>& v) {
    return math::is_finite(v.squaredNorm());
}

}  // namespace

void Attitude::step(AttitudePorts& ports) {
    if (!ports.gyro || !is_finite(math::vector(ports.gyro->xyz))) return;
    const std::optional<float> dt = gyro_clock_.advance(ports.gyro->timestamp_sample);
    if (!dt) return;
    if (*dt > kLongestGap) restart();
    rate_B_ = math::vector(ports.gyro->xyz);
    inclination_.turn(rate_B_ - bias_.value(), *dt);
    update_inclination(ports);
    if (!aligned_) return;
    update_heading(ports);
    ports.attitude.publish([&] {
        const math::Quaternion<float> q_NB = heading_.q_NT() * inclination_.q_TB();
        return VehicleAttitude{.timestamp_sample = ports.gyro->timestamp_sample,
                               .q = math::to_array(q_NB)};
    });
}

void Attitude::restart() {
    inclination_.restart();
    bias_.restart();
    correction_clock_ = SampleClock();
    rates_B_ = Average();
    forces_B_ = Average();
}

void Attitude::update_inclination(AttitudePorts& ports) {
    if (!ports.accel || !ports.accel.is_new() || !is_finite(math::vector(ports.accel->xyz))) return;
    const Vector force_B = math::vector(ports.accel->xyz);
    inclination_.feel(force_B);
    rates_B_.add(rate_B_);
    forces_B_.add(force_B);
    if (!correction_clock_.is_due(ports.accel->timestamp_sample, kCorrectionInterval)) return;
    const bool armed =
        ports.status && ports.status->arming_state == VehicleStatus::ArmingState::kArmed;
    correct_inclination(*correction_clock_.advance(ports.accel->timestamp_sample), !armed,
                        *ports.params);
}

void Attitude::correct_inclination(float dt, bool may_rest, const AttitudeParams& params) {
    bias_.predict(dt, params);
    bias_.update_rest(rates_B_.take(), forces_B_.take(), may_rest, dt, params);
    const float time_constant =
        bias_.at_rest() ? params.accel_time_constant_at_rest : params.accel_time_constant;
    const Eigen::Vector2f turned = inclination_.correct(dt, time_constant);
    aligned_ = true;
    if (dt <= 0.0F) return;
    const Eigen::Vector2f drift_T = turned * (1.0F / dt);
    bias_.update_inclination(inclination_.q_TB().toRotationMatrix(), drift_T, dt, time_constant,
                             params);
}

void Attitude::update_heading(AttitudePorts& ports) {
    if (ports.heading && ports.heading.is_new()) use_motion_capture(*ports.heading, *ports.params);
    if (ports.now < capture_until_us_) return;
    if (ports.mag && ports.mag.is_new()) use_magnetometer(*ports.mag, *ports.params);
}

void Attitude::use_motion_capture(const VehicleOdometry& seen, const AttitudeParams& params) {
    const math::Quaternion<float> q_seen = math::quaternion(seen.q);
    const math::Matrix3<float> R_TB = inclination_.q_TB().toRotationMatrix();
    const float level_nose = R_TB.col(0).head<2>().squaredNorm();
    if (!math::is_finite(q_seen.squaredNorm()) || level_nose < math::square(kMinLevelNose)) return;
    const std::optional<float> elapsed = capture_clock_.advance(seen.timestamp_sample);
    if (!elapsed) return;
    const bool restarts = *elapsed > kLongestCaptureGap;
    if (restarts) capture_gain_.restart();
    const float dt = restarts ? 0.0F : *elapsed;
    capture_until_us_ = seen.timestamp_sample + kCaptureHold;
    const float gain = capture_gain_.next(dt, params.heading_time_constant);
    const float heading_T = math::atan2(R_TB(1, 0), R_TB(0, 0));
    const float turn = gain * heading_.error(heading_T, math::heading(q_seen));
    heading_.turn(turn);
    if (dt > 0.0F) bias_.update_heading(R_TB, -turn / dt, gain, dt, params);
}

void Attitude::use_magnetometer(const SensorMag& sample, const AttitudeParams& params) {
    const Vector field_B = math::vector(sample.xyz);
    if (!is_finite(field_B)) return;
    const std::optional<float> dt = mag_clock_.advance(sample.timestamp_sample);
    if (!dt) return;
    const Vector field_T = inclination_.q_TB() * field_B;
    const bool moving = rate_B_.squaredNorm() > math::square(kMoving);
    const float trust = field_.trust(field_T, moving, *dt, params);
    const float heading_T = math::atan2(field_T.y(), field_T.x());
    const float error = heading_.error(heading_T, params.magnetic_declination);
    heading_.turn(mag_gain_.next(*dt, params.mag_time_constant, trust) * error);
}

}  // namespace stator::apps::attitude
