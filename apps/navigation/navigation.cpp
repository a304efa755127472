// Navigation: what comes in, and what an activation does.
#include "navigation.hpp"

namespace stator::apps::navigation {

namespace {

// A vehicle that stands is not carried so far between two fixes.
constexpr double kElsewhere = 1000.0;  // m
// So many equal samples come from a part that is stuck.
constexpr unsigned kFrozenImu = 100;
constexpr unsigned kFrozenBaro = 50;
// Of one axis: it turns faster than the gyro can measure.
constexpr unsigned kClippedGyro = 30;
constexpr unsigned kFrozenGnss = 3;
// Without IMU samples for so long, nothing is known.
constexpr float kSilent = 0.1F;  // s
// What leans so far has lost control, and turns as no gyro of this kind can be trusted.
constexpr float kTumbled = 0.17F;  // the cosine of 80 deg
// A longer gap between IMU samples cannot be integrated across.
constexpr float kLongestGap = 2.0F;  // s
// The magnetometer and the barometer are thinned to this: more costs time and tells little.
constexpr uint64_t kMinInterval_us = 40'000;
// Fixes that the receiver itself takes to be worse than this are not fused.
constexpr float kWorstPosition = 25.0F;  // m
constexpr float kWorstVelocity = 5.0F;   // m/s
// The standard atmosphere up to 11 km (ISO 2533): h = 44330.8 m (1 - (p / 101325 Pa)^0.190263).
constexpr float kScaleHeight = 44330.8F;
constexpr float kPressureAtSea = 101325.0F;
constexpr float kPressureExponent = 0.190263F;
// At rest: no turning beyond the gyro's noise, and nothing felt but gravity.
constexpr float kRestRate = 0.05F;  // rad/s
constexpr float kRestForce = 0.5F;  // m/s^2

bool is_finite(const Vector& v) {
    return math::is_finite(v.squaredNorm());
}

// Of all motors: one that stands still gives nothing.
float sum_of_commands(const ActuatorMotors& motors) {
    float sum = 0.0F;
    for (const float control : motors.control) sum += math::is_finite(control) ? control : 0.0F;
    return sum;
}

// A variance from what the receiver says of its error.
float variance_of(float error, float least) {
    return math::square(error > least ? error : least);
}

}  // namespace

void Navigation::step(NavigationPorts& ports) {
    const NavigationParams& params = *ports.params;
    if (ports.status)
        disarmed_ = ports.status->arming_state == VehicleStatus::ArmingState::kDisarmed;
    flies_ = ports.land && !ports.land->landed && !disarmed_ && ports.motors;
    has_flown_ = !disarmed_ && (has_flown_ || flies_);
    if (ports.motors) command_ = sum_of_commands(*ports.motors);
    if (disarmed_) {
        disagreement_.jump_N.setZero();
        receiver_jump_N_.setZero();
    }
    now_us_ = ports.now;
    const bool moved_on = read_imu(ports);
    if (!started_) return;
    while (ports.gnss.next()) {
        if (is_of_the_past(ports.gnss->timestamp_sample)) read_gnss(*ports.gnss, params);
    }
    const float thrust = ports.thrust ? -ports.thrust->xyz[2] : 0.0F;
    const float wash = params.baro_wash * (math::is_finite(thrust) ? thrust : 0.0F);
    while (ports.baro.next()) {
        if (is_of_the_past(ports.baro->timestamp_sample)) read_baro(*ports.baro, wash);
    }
    while (ports.mag.next()) {
        if (is_of_the_past(ports.mag->timestamp_sample)) read_mag(*ports.mag);
    }
    work(params);
    if (moved_on)
        publish(ports);
    else if (imu_age() > kSilent)
        publish_lost(ports);
    if (measured_) publish_state(ports);
    measured_ = false;
}

// Pairs each gyro sample with the accelerometer's of the same instant, or the one after.
bool Navigation::read_imu(NavigationPorts& ports) {
    bool any = false;
    while (ports.gyro.next()) {
        const uint64_t time_us = ports.gyro->timestamp_sample;
        const float dt = time_us > imu_us_ ? static_cast<float>(time_us - imu_us_) * 1e-6F : 0.0F;
        const Vector rate_B = gyro_spike_.without(math::vector(ports.gyro->xyz), dt);
        const float value = rate_B.x() + 2.0F * rate_B.y() + 4.0F * rate_B.z();
        if (frozen_gyro_.update(value, kFrozenImu) && has_flown_) continue;
        while (accel_us_ < time_us && ports.accel.next()) {
            const Vector force_B = math::vector(ports.accel->xyz);
            if (!is_finite(force_B)) continue;
            accel_us_ = ports.accel->timestamp_sample;
            queued_force_B_ = accel_spike_.without(force_B, dt);
        }
        for (unsigned axis = 0; axis < 3; ++axis) {
            if (clipped_gyro_[axis].update(rate_B(axis), kClippedGyro) && flies_)
                astray_us_ = time_us;
        }
        if (accel_us_ == 0 || time_us <= imu_us_ || !is_finite(rate_B)) continue;
        add_imu(time_us, rate_B, *ports.params);
        any = true;
    }
    return any;
}

// Samples are of instants: between two, their mean is felt.
void Navigation::add_imu(uint64_t time_us, const Vector& rate_B, const NavigationParams& params) {
    const float dt = imu_us_ == 0 ? 0.0F : static_cast<float>(time_us - imu_us_) * 1e-6F;
    const Vector rate = (rate_B + rate_B_) * 0.5F;
    const Vector force = (queued_force_B_ + force_B_) * 0.5F;
    imu_us_ = time_us;
    rate_B_ = rate_B;
    force_B_ = queued_force_B_;
    if (dt > kLongestGap) {
        started_ = false;
        alignment_ = Alignment();
    }
    if (dt == 0.0F || dt > kLongestGap) return;
    if (!started_) {
        if (alignment_.add(force, dt)) start(params);
        return;
    }
    watch_rest(rate, force, dt);
    if (flies_ && velocity_aid_.refused_for(filter_.time_us()) == 0.0F)
        proven_s_ = math::min(proven_s_ + dt, kProven_s);
    // Until then satellites may still find what the compass is wrong by.
    if (proven_s_ < kProven_s) proven_mag_offset_ = filter_.mag_offset();
    const Quaternion& q = filter_.kinematics().q_NB;
    const float cos_tilt = 1.0F - 2.0F * (math::square(q.x()) + math::square(q.y()));
    if (flies_ && cos_tilt < kTumbled) astray_us_ = time_us;
    if (flies_)
        doubt_.update(command_, force, dt);
    else if (!has_flown_)
        doubt_.reset();
    if (flies_ && filter_.has_impossible_accel_bias()) {
        doubt_.refuted();
        filter_.forget_accel_bias();
    }
    // Commands say better what is felt than an accelerometer that cannot be right.
    window_.add(rate, doubt_.now() ? doubt_.expected() : force, dt);
    if (window_.open_time() + 0.5F * dt < params.step_time) return;
    if (window_.full()) predict(params, true);
    window_.close(time_us, filter_.bias());
    doubt_.follow_wind(filter_.kinematics().q_NB, params.step_time);
}

void Navigation::start(const NavigationParams& params) {
    constexpr float kUnknownHeading = 3.2F;   // rad^2, of a heading that may be any
    constexpr float kLostPosition = 2500.0F;  // m^2
    constexpr float kLostVelocity = 100.0F;   // m^2/s^2
    const Vector before_N = filter_.kinematics().position_N;
    filter_.start(imu_us_, alignment_.attitude(), alignment_.tilt_variance(), kUnknownHeading,
                  params);
    if (was_started_) {
        // In flight it may have gone anywhere meanwhile, and fast.
        filter_.set_horizontal_position(before_N.head<2>(), kLostPosition);
        filter_.set_down(before_N.z(), kLostPosition);
        filter_.set_horizontal_velocity(Eigen::Vector2f::Zero(), kLostVelocity);
        filter_.set_vertical_velocity(0.0F, kLostVelocity);
    }
    was_started_ = true;
    window_.restart(imu_us_, filter_.bias());
    alignment_ = Alignment();
    velocity_aid_ = position_aid_ = height_aid_ = heading_aid_ = Aid();
    output_correction_ = OutputCorrection();
    disagreement_ = Disagreement();
    proven_s_ = 0.0F;
    gnss_next_ = rest_next_ = 0;
    rest_due_us_ = output_us_ = imu_us_;
    started_ = true;
}

void Navigation::watch_rest(const Vector& rate_B, const Vector& force_B, float dt) {
    const Vector rate = rate_B - filter_.bias().gyro;
    const float excess = math::norm(force_B) - kGravity;
    const bool still =
        disarmed_ && rate.squaredNorm() < math::square(kRestRate) && math::abs(excess) < kRestForce;
    rest_s_ = still ? math::min(rest_s_ + dt, kRestTime) : 0.0F;
}

void Navigation::read_gnss(const SensorGps& fix, const NavigationParams& params) {
    const bool is_known = math::is_finite(fix.latitude_deg) && math::is_finite(fix.longitude_deg) &&
                          math::is_finite(fix.altitude_msl_m);
    const Vector velocity_N(fix.vel_n_m_s, fix.vel_e_m_s, fix.vel_d_m_s);
    // Where a receiver without a position has it.
    const bool is_nowhere = fix.latitude_deg == 0.0 && fix.longitude_deg == 0.0;
    const bool is_3d = fix.fix_type >= SensorGps::FixType::kFix3d;
    if (!is_3d || !is_known || is_nowhere || !(fix.eph <= kWorstPosition)) return;
    if (!has_origin_) {
        frame_ = math::LocalFrame({fix.latitude_deg, fix.longitude_deg});
        origin_us_ = fix.timestamp_sample;
        has_origin_ = true;
    }
    const bool has_height = fix.epv <= kWorstPosition;
    auto at = frame_.to_local({fix.latitude_deg, fix.longitude_deg});
    if (disarmed_ && math::abs(at.north) + math::abs(at.east) > kElsewhere) {
        // The first fix was wrong. Nothing has used the origin yet.
        frame_ = math::LocalFrame({fix.latitude_deg, fix.longitude_deg});
        origin_us_ = fix.timestamp_sample;
        position_aid_ = Aid();
        at = {};
    }
    const GnssMeasurement measurement{
        .time_us = fix.timestamp_sample,
        .velocity_N = velocity_N,
        .position_N = Vector(static_cast<float>(at.north), static_cast<float>(at.east), 0.0F),
        .height = fix.altitude_msl_m,
        .velocity_variance = variance_of(fix.s_variance_m_s, params.gnss_velocity_noise),
        .position_variance = variance_of(fix.eph, params.gnss_position_noise),
        .height_variance = variance_of(fix.epv, params.gnss_height_noise),
        .has_velocity =
            fix.vel_ned_valid && is_finite(velocity_N) && fix.s_variance_m_s <= kWorstVelocity,
        .has_height = has_height};
    const float value = measurement.position_N.x() + 2.0F * measurement.position_N.y() +
                        4.0F * velocity_N.x() + 8.0F * velocity_N.y();
    // Some receivers hold what stands; what flies changes.
    if (frozen_gnss_.update(value, kFrozenGnss) && has_flown_) return;
    if (!gnss_.push(measurement)) ++late_;
}

void Navigation::read_baro(const SensorBaro& sample, float wash) {
    const float pressure = sample.pressure - wash;
    if (!(pressure > 0.0F) || !math::is_finite(pressure)) return;
    if (frozen_baro_.update(sample.pressure, kFrozenBaro) && has_flown_) return;
    if (sample.timestamp_sample < baro_.newest_us() + kMinInterval_us) return;
    const float ratio = math::pow(pressure / kPressureAtSea, kPressureExponent);
    if (!baro_.push({sample.timestamp_sample, kScaleHeight * (1.0F - ratio)})) ++late_;
}

void Navigation::read_mag(const SensorMag& sample) {
    const Vector field_B = math::vector(sample.xyz);
    if (!is_finite(field_B)) return;
    if (sample.timestamp_sample < mag_.newest_us() + kMinInterval_us) return;
    if (!mag_.push({sample.timestamp_sample, field_B})) ++late_;
}

}  // namespace stator::apps::navigation
