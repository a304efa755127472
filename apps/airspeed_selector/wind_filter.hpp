// The wind, from ground speed and airspeed, and from the fact that an aeroplane does not slip.
#pragma once

#include "stator/rotation.hpp"

namespace stator::apps::airspeed_selector {

// State: wind north and east. Extended Kalman filter of
//
//     airspeed = |v - wind|         sideslip = y over x of R_NB^T (v - wind) = 0
//
// Cho et al.: Wind Estimation and Airspeed Calibration using a UAV with a Single-Antenna GPS
// Receiver and Pitot Tube, IEEE TAES 47(1), 2011. Without its third state, the scale of the sensor:
// in gusts that last for seconds, on a straight way, scale and wind run away together.
class WindFilter {
  public:
    using Vector2 = Eigen::Matrix<float, 2, 1>;

    bool is_running() const { return is_running_; }
    void reset() { is_running_ = false; }
    // The air comes from ahead.
    void start(const math::Vector3<float>& v_N, float heading, float airspeed);
    void predict(float dt, float wind_walk);
    // Further off than `gate` sigmas, a measurement is left out.
    void fuse_airspeed(const math::Vector3<float>& v_N, float airspeed, float sigma, float gate);
    void fuse_sideslip(const math::Vector3<float>& v_N, const math::Quaternion<float>& q_NB,
                       float sigma, float gate);

    math::Vector3<float> air_N(const math::Vector3<float>& v_N) const {
        return {v_N.x() - wind_.x(), v_N.y() - wind_.y(), v_N.z()};
    }
    const Vector2& wind() const { return wind_; }
    float variance_north() const { return P_(0, 0); }
    float variance_east() const { return P_(1, 1); }

  private:
    void fuse(float innovation, const Vector2& H, float variance, float gate);

    bool is_running_ = false;
    Vector2 wind_ = Vector2::Zero();
    Eigen::Matrix<float, 2, 2> P_ = Eigen::Matrix<float, 2, 2>::Zero();
};

}  // namespace stator::apps::airspeed_selector
