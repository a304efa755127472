// The wind.
#include "wind_filter.hpp"

namespace stator::apps::airspeed_selector {

using math::Vector3;
using Matrix2 = Eigen::Matrix<float, 2, 2>;

namespace {

constexpr float kStartWind = 4.0F;  // m/s, 1 sigma
constexpr float kSlow = 1.0F;       // m/s

}  // namespace

void WindFilter::start(const Vector3<float>& v_N, float heading, float airspeed) {
    const math::SinCos<float> nose = math::sincos(heading);
    wind_ = {v_N.x() - airspeed * nose.cos, v_N.y() - airspeed * nose.sin};
    P_ = math::square(kStartWind) * Matrix2::Identity();
    is_running_ = true;
}

void WindFilter::predict(float dt, float wind_walk) {
    P_ += math::square(wind_walk) * dt * Matrix2::Identity();
}

// Joseph's form, which keeps P symmetric and positive.
void WindFilter::fuse(float innovation, const Vector2& H, float variance, float gate) {
    const Vector2 PH = P_ * H;
    const float S = H.dot(PH) + variance;
    const bool is_near = math::square(innovation) <= math::square(gate) * S;
    if (!is_near) return;  // nor is what is not a number
    const Vector2 K = PH / S;
    wind_ += K * innovation;
    const Matrix2 left = Matrix2::Identity() - K * H.transpose();
    const Matrix2 P = left * P_ * left.transpose() + variance * K * K.transpose();
    P_ = P;
}

void WindFilter::fuse_airspeed(const Vector3<float>& v_N, float airspeed, float sigma, float gate) {
    const Vector3<float> air = air_N(v_N);
    const float speed = math::norm(air);
    if (speed < kSlow) return;
    fuse(airspeed - speed, {-air.x() / speed, -air.y() / speed}, math::square(sigma), gate);
}

void WindFilter::fuse_sideslip(const Vector3<float>& v_N, const math::Quaternion<float>& q_NB,
                               float sigma, float gate) {
    const math::Matrix3<float> R_NB = q_NB.toRotationMatrix();
    const Vector3<float> air_B = R_NB.transpose() * air_N(v_N);
    if (air_B.x() < kSlow) return;
    const float slip = air_B.y() / air_B.x();
    // d slip / d wind = -(R y - slip R x) / u
    const Vector3<float> by_air = (R_NB.col(1) - slip * R_NB.col(0)) / air_B.x();
    fuse(-slip, {-by_air.x(), -by_air.y()}, math::square(sigma), gate);
}

}  // namespace stator::apps::airspeed_selector
