// Gyro bias: Kalman filter and detection of rest.
#include "gyro_bias.hpp"

namespace stator::apps::attitude {

namespace {

// Seconds in which an uncertainty of zero grows to `bias_uncertainty_in_motion`.
constexpr float kForgettingTime = 100.0F;
constexpr float kRestTimeConstant = 0.5F;

float growth(const AttitudeParams& params) {
    return math::square(params.bias_uncertainty_in_motion) / kForgettingTime;
}

// Noise of a measurement each `dt` with which the variance settles at sigma^2: its growth per step,
// growth * dt, is then what a step takes away, sigma^4 / noise.
float noise_for(float sigma, float dt, const AttitudeParams& params) {
    return math::square(math::square(sigma)) / (growth(params) * dt);
}

}  // namespace

void GyroBias::predict(float dt, const AttitudeParams& params) {
    const float most = math::square(params.bias_uncertainty);
    if (!started_) {
        covariance_.diagonal().setConstant(most);
        started_ = true;
    }
    for (int axis = 0; axis < 3; ++axis) {
        if (covariance_(axis, axis) < most) covariance_(axis, axis) += growth(params) * dt;
        bias_(axis) = math::clamp(bias_(axis), -params.bias_limit, params.bias_limit);
    }
}

void GyroBias::update_rest(const Vector& rate_B, const Vector& force_B, bool may_rest, float dt,
                           const AttitudeParams& params) {
    rate_B_.update(rate_B, dt, kRestTimeConstant);
    force_B_.update(force_B, dt, kRestTimeConstant);
    const float moves = (rate_B - rate_B_.value()).squaredNorm();
    const float shakes = (force_B - force_B_.value()).squaredNorm();
    const bool quiet = may_rest && moves < math::square(params.rest_gyro_deviation) &&
                       shakes < math::square(params.rest_accel_deviation) &&
                       rate_B_.value().cwiseAbs().maxCoeff() < params.bias_limit;
    quiet_s_ = quiet ? math::min(quiet_s_ + dt, params.rest_least_time) : 0.0F;
    at_rest_ = quiet && quiet_s_ >= params.rest_least_time;
    if (!at_rest_ || dt <= 0.0F) return;
    const float noise = noise_for(params.bias_uncertainty_at_rest, dt, params);
    const Vector innovation = rate_B_.value() - bias_;
    for (int axis = 0; axis < 3; ++axis) correct(Vector::Unit(axis), innovation(axis), noise);
}

void GyroBias::update_inclination(const math::Matrix3<float>& R_TB, const Eigen::Vector2f& drift_T,
                                  float dt, float time_constant, const AttitudeParams& params) {
    Eigen::Matrix<float, 2, 4> rows;
    rows << R_TB.topRows<2>(), R_TB.topRows<2>() * bias_;
    inclination_.update(rows, dt, time_constant);
    if (at_rest_ || dt <= 0.0F) return;
    const float noise = noise_for(params.bias_uncertainty_in_motion, dt, params);
    for (int row = 0; row < 2; ++row) {
        const Vector direction = inclination_.value().row(row).head<3>();
        const float measured = drift_T(row) + inclination_.value()(row, 3);
        correct(direction, measured - direction.dot(bias_), noise);
    }
}

void GyroBias::update_heading(const math::Matrix3<float>& R_TB, float drift, float gain, float dt,
                              const AttitudeParams& params) {
    Eigen::Vector4f row;
    row << R_TB.row(2).transpose(), R_TB.row(2).dot(bias_);
    heading_ += (row - heading_) * gain;
    if (at_rest_ || dt <= 0.0F) return;
    const Vector direction = heading_.head<3>();
    const float measured = drift + heading_(3);
    const float noise = noise_for(params.bias_uncertainty_at_rest, dt, params);
    correct(direction, measured - direction.dot(bias_), noise);
}

void GyroBias::restart() {
    inclination_.restart();
    rate_B_.restart();
    force_B_.restart();
    quiet_s_ = 0.0F;
    at_rest_ = false;
}

void GyroBias::correct(const Vector& direction, float innovation, float noise) {
    const Vector spread = covariance_ * direction;
    const float scale = 1.0F / (direction.dot(spread) + noise);
    bias_ += spread * (innovation * scale);
    covariance_ -= spread * spread.transpose() * scale;
}

}  // namespace stator::apps::attitude
