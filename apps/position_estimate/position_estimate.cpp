// Position estimation: what each input does, and what is valid when.
#include "position_estimate.hpp"

namespace stator::apps::position_estimate {

namespace {

using Vector = math::Vector3<float>;

constexpr float kGravity = 9.80665F;  // m/s^2, standard
// A longer gap cannot be predicted across.
constexpr float kLongestGap = 0.1F;  // s
// Two positions this far apart give a velocity: millimetres of noise make centimetres per second.
constexpr uint64_t kAcquisition = 50'000;  // us

float seconds(uint64_t elapsed_us) {
    return static_cast<float>(elapsed_us) * 1e-6F;
}

}  // namespace

void PositionEstimate::step(PositionEstimatePorts& ports) {
    gather(ports);
    const bool is_newer = predict(ports);
    if (ports.mocap && time_us_ != 0) measure(*ports.mocap, *ports.params);
    if (!is_newer || measured_us_ == 0) return;
    ports.position.publish([&] { return estimate(*ports.params); });
}

// Adds up the new samples: all of them, if the graph gives them as a queue.
void PositionEstimate::gather(PositionEstimatePorts& ports) {
    while (ports.accel.next()) {
        const Vector force_B = math::vector(ports.accel->xyz);
        if (!math::is_finite(force_B.squaredNorm())) continue;
        forces_B_ += force_B;
        force_count_ += 1.0F;
    }
}

// True if the estimate's time moved on.
bool PositionEstimate::predict(const PositionEstimatePorts& ports) {
    if (!ports.attitude || force_count_ == 0.0F) return false;
    const math::Quaternion<float> q_NB = math::quaternion(ports.attitude->q);
    const Vector force_B = forces_B_ * (1.0F / force_count_);
    const Vector acceleration_N = q_NB * force_B + Vector(0.0F, 0.0F, kGravity);
    const uint64_t time_us = ports.attitude->timestamp_sample;
    if (time_us <= time_us_ || !math::is_finite(acceleration_N.squaredNorm())) return false;
    const float dt = time_us_ == 0 ? 0.0F : seconds(time_us - time_us_);
    time_us_ = time_us;
    heading_ = math::heading(q_NB);
    forces_B_ = Vector::Zero();
    force_count_ = 0.0F;
    if (dt > kLongestGap) state_ = State::kLost;
    if (state_ != State::kLost) filter_.predict(acceleration_N, dt);
    return true;
}

float PositionEstimate::age_of(uint64_t time_us) const {
    return time_us > time_us_ ? -seconds(time_us - time_us_) : seconds(time_us_ - time_us);
}

void PositionEstimate::measure(const VehicleOdometry& seen, const PositionEstimateParams& params) {
    const Vector position = math::vector(seen.position);
    const uint64_t time_us = seen.timestamp_sample;
    const float age = age_of(time_us);
    if (!math::is_finite(position.squaredNorm()) || time_us <= measured_us_) return;
    if (math::abs(age) > params.mocap_longest_delay) return;
    const float since = seconds(time_us - measured_us_);
    if (state_ == State::kLost || since > params.mocap_timeout) {
        begin_acquisition(position, time_us);
        return;
    }
    if (state_ == State::kAcquiring) {
        measured_us_ = time_us;
        if (time_us - acquired_us_ >= kAcquisition) end_acquisition(position, time_us);
        return;
    }
    const Vector innovation = position - filter_.position_ago(age);
    if (innovation.squaredNorm() > math::square(params.mocap_gate)) return;
    measured_us_ = time_us;
    filter_.correct(innovation, since, params.bandwidth, params.bias_bandwidth);
}

// Takes a position as it is; the velocity stays what was predicted last.
void PositionEstimate::begin_acquisition(const Vector& position, uint64_t time_us) {
    state_ = State::kAcquiring;
    acquired_ = position;
    acquired_us_ = time_us;
    measured_us_ = time_us;
    const Vector velocity = filter_.velocity();
    filter_.restart(position + velocity * age_of(time_us), velocity);
}

// Takes the velocity from two positions.
void PositionEstimate::end_acquisition(const Vector& position, uint64_t time_us) {
    state_ = State::kTracking;
    const Vector velocity = (position - acquired_) * (1.0F / seconds(time_us - acquired_us_));
    filter_.restart(position + velocity * age_of(time_us), velocity);
}

VehicleLocalPosition PositionEstimate::estimate(const PositionEstimateParams& params) const {
    const bool is_recent = age_of(measured_us_) <= params.mocap_timeout;
    const bool has_position = is_recent && state_ != State::kLost;
    const bool has_velocity = is_recent && state_ == State::kTracking;
    return {.timestamp_sample = time_us_,
            .x = filter_.position().x(),
            .y = filter_.position().y(),
            .z = filter_.position().z(),
            .vx = filter_.velocity().x(),
            .vy = filter_.velocity().y(),
            .vz = filter_.velocity().z(),
            .heading = heading_,
            .xy_valid = has_position,
            .z_valid = has_position,
            .v_xy_valid = has_velocity,
            .v_z_valid = has_velocity};
}

}  // namespace stator::apps::position_estimate
