// Wind and scale of an airspeed sensor.
#include "wind_filter.hpp"

namespace stator::apps::airspeed_selector {

using math::Matrix3;
using math::Vector3;

namespace {

constexpr float kStartWind = 4.0F;     // m/s, 1 sigma; less across the nose than along it
constexpr float kUnknownWind = 10.0F;  // m/s, without an airspeed
constexpr float kStartScale = 0.05F;
constexpr float kSlow = 1.0F;  // m/s

}  // namespace

void WindFilter::start(const Vector3<float>& v_N, float heading, float airspeed) {
    const bool is_known = math::is_finite(airspeed);
    const math::SinCos<float> nose = math::sincos(heading);
    state_ = {0.0F, 0.0F, 1.0F};
    if (is_known) {
        state_.x() = v_N.x() - airspeed * nose.cos;
        state_.y() = v_N.y() - airspeed * nose.sin;
    }
    const float sigma = is_known ? kStartWind : kUnknownWind;
    P_ = Vector3<float>(math::square(sigma), math::square(sigma), math::square(kStartScale))
             .asDiagonal();
    is_running_ = true;
}

void WindFilter::predict(float dt, const Noise& noise) {
    P_(0, 0) += math::square(noise.wind_walk) * dt;
    P_(1, 1) += math::square(noise.wind_walk) * dt;
    P_(2, 2) += math::square(noise.scale_walk) * dt;
}

// Joseph's form, which keeps P symmetric and positive.
bool WindFilter::fuse(float innovation, const Vector3<float>& H, float variance, float gate) {
    const Vector3<float> PH = P_ * H;
    const float S = H.dot(PH) + variance;
    if (!math::is_finite(innovation) || math::square(innovation) > math::square(gate) * S) {
        return false;
    }
    const Vector3<float> K = PH / S;
    state_ += K * innovation;
    state_.z() = math::clamp(state_.z(), 0.5F, 1.5F);
    const Matrix3<float> left = Matrix3<float>::Identity() - K * H.transpose();
    const Matrix3<float> P = left * P_ * left.transpose() + variance * K * K.transpose();
    P_ = P;
    return true;
}

bool WindFilter::fuse_airspeed(const Vector3<float>& v_N, float airspeed, float sigma,
                               float gate) {
    const Vector3<float> air = air_N(v_N);
    const float speed = math::norm(air);
    if (speed < kSlow) return false;
    const Vector3<float> H(-scale() * air.x() / speed, -scale() * air.y() / speed, speed);
    return fuse(airspeed - scale() * speed, H, math::square(sigma), gate);
}

bool WindFilter::fuse_sideslip(const Vector3<float>& v_N, const math::Quaternion<float>& q_NB,
                               float sigma, float gate) {
    const Matrix3<float> R_NB = q_NB.toRotationMatrix();
    const Vector3<float> air_B = R_NB.transpose() * air_N(v_N);
    if (air_B.x() < kSlow) return false;
    const float slip = air_B.y() / air_B.x();
    // d slip / d wind = -(R y - slip R x) / u
    const Vector3<float> by_air = (R_NB.col(1) - slip * R_NB.col(0)) / air_B.x();
    return fuse(-slip, {-by_air.x(), -by_air.y(), 0.0F}, math::square(sigma), gate);
}

}  // namespace stator::apps::airspeed_selector
