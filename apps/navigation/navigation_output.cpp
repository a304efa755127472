// Navigation: the estimate as others see it.
#include "navigation.hpp"

namespace stator::apps::navigation {

namespace {

// Over how long a correction reaches the output: slow against what a controller would answer.
constexpr float kSmoothing = 0.25F;     // s
constexpr float kGoodHeading = 0.35F;   // rad, 1 sigma
constexpr float kCoasting = 1.0F;       // s without satellites that count as dead reckoning
constexpr float kGoodPosition = 20.0F;  // m, 1 sigma
constexpr float kGoodHeight = 10.0F;    // m, 1 sigma

// A wrong velocity carries the position away for so long, until fixes bring it back; where these
// are left out, for as long as they are.
constexpr float kCarried = 1.5F;  // s

// An IMU whose samples are so old says where the vehicle was; from then on it may do anything.
constexpr float kLate = 0.1F;       // s
constexpr float kLateSpeed = 5.0F;  // m/s

// A yaw rate that the gyro measures with 3 %, and a little late.
constexpr float kTurning = 0.05F;  // s
// What a barometer that drifts may carry the estimate by where satellites are refused.
constexpr float kOneWitness = 0.5F;  // m/s
constexpr float kOneWitness_s = 0.5F;

// Of a receiver that contradicts itself less than counts against it, squared.
float small_contradiction(float squared) {
    constexpr float kShare = 0.5F;
    constexpr float kUsual = 0.5F;  // m/s
    return math::square(kShare) * math::max(squared - math::square(kUsual), 0.0F);
}

constexpr float kGoodVelocity = 2.0F;       // m/s, 1 sigma
constexpr float kGoodLevelVelocity = 4.0F;  // the same for the horizontal one

// `slow`: what is the same for minutes, so that the filter cannot know it.
float deviation(float variance, float slow = 0.0F) {
    return math::sqrt(variance + math::square(slow));
}

}  // namespace

// A correction moved the estimate; the output goes on from where it was.
void Navigation::smooth(const Kinematics& before, const Kinematics& after) {
    const Quaternion turn = math::shortest(Quaternion(before.q_NB * after.q_NB.conjugate()));
    output_correction_.turn_N += turn.vec() * 2.0F;
    output_correction_.velocity_N += before.velocity_N - after.velocity_N;
    output_correction_.position_N += before.position_N - after.position_N;
}

Kinematics Navigation::output() const {
    Kinematics now = moved(filter_.kinematics(), window_.ahead());
    now.q_NB = math::normalized(math::from_rotation_vector(output_correction_.turn_N) * now.q_NB);
    now.velocity_N += output_correction_.velocity_N;
    now.position_N += output_correction_.position_N;
    return now;
}

void Navigation::publish(NavigationPorts& ports) {
    const float dt = static_cast<float>(imu_us_ - output_us_) * 1e-6F;
    const float keep = kSmoothing / (kSmoothing + dt);
    output_us_ = imu_us_;
    output_correction_.turn_N *= keep;
    output_correction_.velocity_N *= keep;
    output_correction_.position_N *= keep;
    const Kinematics now = output();
    ports.position.publish([&] { return local_position(now, *ports.params); });
    ports.attitude.publish([&] {
        return VehicleAttitude{.timestamp_sample = imu_us_, .q = math::to_array(now.q_NB)};
    });
}

void Navigation::publish_lost(NavigationPorts& ports) const {
    VehicleLocalPosition lost = local_position(output(), *ports.params);
    lost.xy_valid = lost.z_valid = lost.v_xy_valid = lost.v_z_valid = false;
    lost.heading_good_for_control = false;
    ports.position.publish([&] { return lost; });
}

// Satellites and barometer both show how fast it sinks: one of them that agrees is enough.
float Navigation::vertical_disagreement() const {
    const float satellites = disagreement_.vertical_velocity() +
                             inconsistency_variance(math::square(contradiction_N_.z()));
    if (baro_has_failed_ || !baro_rate_.known(filter_.time_us())) return satellites;
    const bool contradicts_itself =
        inconsistency_variance(math::square(contradiction_N_.z())) > 0.0F;
    const bool is_alone = vertical_refused_s_ > kOneWitness_s || contradicts_itself;
    const float alone = is_alone ? math::square(kOneWitness) : 0.0F;
    return math::min(satellites, math::square(disagreement_.baro_velocity) + alone);
}

// A magnetometer's error that appears in flight is the magnetometer's, or the heading's.
float Navigation::nose_variance() const {
    const float moved = math::wrap_pi(filter_.mag_offset() - proven_mag_offset_);
    // A field that dips turns by twice the tilt's error.
    constexpr float kThroughTilt = 0.5F;        // rad
    constexpr uint64_t kFinds_us = 10'000'000;  // the time to find it again
    const bool is_astray = astray_us_ != 0 && imu_us_ - astray_us_ < kFinds_us;
    const float tilted = filter_.has_impossible_bias() || is_astray ? kThroughTilt : 0.0F;
    return filter_.variance(kHeading) + disagreement_.nose() + math::square(moved) +
           math::square(tilted) + math::square(kTurning * filter_.heading_rate());
}

VehicleLocalPosition Navigation::local_position(const Kinematics& now,
                                                const NavigationParams& params) const {
    const auto variance = [this](unsigned state) { return filter_.variance(state); };
    const float timeout = params.dead_reckoning_timeout;
    const float position = variance(kPosition) + variance(kPosition + 1);
    const bool position_aided = position_aid_.recent(filter_.time_us(), timeout);
    const bool velocity_aided = velocity_aid_.recent(filter_.time_us(), timeout);
    const bool height_aided = height_aid_.recent(filter_.time_us(), timeout);
    const Vector acceleration_N =
        now.q_NB * Vector(force_B_ - filter_.bias().accel) + Vector(0.0F, 0.0F, kGravity);
    VehicleLocalPosition result = resets_;
    result.timestamp_sample = imu_us_;
    result.ref_timestamp = origin_us_;
    result.ref_lat = has_origin_ ? frame_.origin().latitude_deg : 0.0;
    result.ref_lon = has_origin_ ? frame_.origin().longitude_deg : 0.0;
    result.ref_alt = static_cast<float>(origin_height_);
    result.x = now.position_N.x();
    result.y = now.position_N.y();
    result.z = now.position_N.z();
    result.vx = now.velocity_N.x();
    result.vy = now.velocity_N.y();
    result.vz = now.velocity_N.z();
    result.ax = acceleration_N.x();
    result.ay = acceleration_N.y();
    result.az = acceleration_N.z();
    result.heading = math::heading(now.q_NB);
    const Disagreement& d = disagreement_;
    const float contradiction = contradiction_N_.head<2>().squaredNorm();
    const float drift = d.level_velocity() + math::max(inconsistency_variance(contradiction),
                                                       small_contradiction(contradiction));
    const bool is_late = imu_age() > kLate;
    const float carried = kCarried + position_aid_.refused_for(filter_.time_us());
    result.eph = deviation(position + d.level_position() + math::square(carried) * drift,
                           params.gnss_slow_error);
    const float moved_on =
        is_late ? math::square(imu_age() * (math::abs(result.vz) + kLateSpeed)) : 0.0F;
    result.epv = deviation(variance(kPosition + 2) + d.height() + moved_on, params.baro_slow_error);
    result.evh = deviation(variance(kVelocity) + variance(kVelocity + 1) + drift);
    result.evv = deviation(variance(kVelocity + 2) + vertical_disagreement());
    const bool heading_is_good = !is_late && nose_variance() < math::square(kGoodHeading);
    const bool coasts = !position_aid_.recent(filter_.time_us(), kCoasting) &&
                        !velocity_aid_.recent(filter_.time_us(), kCoasting);
    // Without satellites, what is felt is turned by the heading's error.
    const bool goes_astray = coasts && !heading_is_good;
    result.xy_valid = position_aided && result.eph < kGoodPosition && !goes_astray && !is_late;
    result.z_valid = height_aided && result.epv < kGoodHeight;
    result.v_xy_valid = (velocity_aided || position_aided) && result.evh < kGoodLevelVelocity &&
                        !goes_astray && !is_late;
    // Satellites know how fast it sinks where the barometer has lost the height.
    const bool is_felt = !doubt_.now() || (doubt_.settled() && velocity_aided);
    result.v_z_valid =
        (height_aided || velocity_aided) && result.evv < kGoodVelocity && is_felt && !is_late;
    result.xy_global = has_origin_;
    result.z_global = has_origin_height_;
    result.heading_good_for_control = heading_is_good;
    result.dead_reckoning = coasts;
    return result;
}

void Navigation::publish_state(NavigationPorts& ports) const {
    ports.innovations.publish([&] { return innovations_; });
    const auto variances = [this](unsigned first) {
        return std::array<float, 3>{filter_.variance(first), filter_.variance(first + 1),
                                    filter_.variance(first + 2)};
    };
    ports.bias.publish([&] {
        return EstimatorSensorBias{.timestamp_sample = filter_.time_us(),
                                   .gyro_bias = math::to_array(filter_.bias().gyro),
                                   .gyro_bias_variance = variances(kGyroBias),
                                   .accel_bias = math::to_array(filter_.bias().accel),
                                   .accel_bias_variance = variances(kAccelBias),
                                   .baro_offset = filter_.baro_offset(),
                                   .mag_offset = filter_.mag_offset()};
    });
    ports.estimator.publish([&] {
        EstimatorStatus status = ratios_;
        status.timestamp_sample = filter_.time_us();
        status.pos_horiz_accuracy =
            deviation(filter_.variance(kPosition) + filter_.variance(kPosition + 1),
                      ports.params->gnss_slow_error);
        status.pos_vert_accuracy =
            deviation(filter_.variance(kPosition + 2), ports.params->baro_slow_error);
        status.tilt_accuracy = deviation(filter_.variance(kTurn) + filter_.variance(kTurn + 1));
        status.heading_accuracy = deviation(nose_variance(), ports.params->mag_slow_error);
        status.late_measurements = late_;
        return status;
    });
}

}  // namespace stator::apps::navigation
