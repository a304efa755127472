// Wind and scale of an airspeed sensor, from ground speed and airspeed, and from the fact that an
// aeroplane does not slip.
#pragma once

#include "stator/rotation.hpp"

namespace stator::apps::airspeed_selector {

// State: wind north, wind east, measured over true airspeed. Extended Kalman filter of
//
//     airspeed = scale |v - wind|         sideslip = y over x of R_NB^T (v - wind) = 0
//
// One filter for each sensor, so that one that is wrong does not spoil another estimate: Stastny,
// in PX4's wind estimator; Cho et al.: Wind Estimation and Airspeed Calibration using a UAV with a
// Single-Antenna GPS Receiver and Pitot Tube, IEEE TAES 47(1), 2011.
class WindFilter {
  public:
    struct Noise {
        float wind_walk;
        float scale_walk;
        float gate;
    };

    bool is_running() const { return is_running_; }
    void reset() { is_running_ = false; }
    // The air comes from ahead; not a number: no airspeed, and no wind until sideslip says more.
    void start(const math::Vector3<float>& v_N, float heading, float airspeed);
    void predict(float dt, const Noise& noise);
    // False: left out.
    bool fuse_airspeed(const math::Vector3<float>& v_N, float airspeed, float sigma, float gate);
    bool fuse_sideslip(const math::Vector3<float>& v_N, const math::Quaternion<float>& q_NB,
                       float sigma, float gate);

    math::Vector3<float> air_N(const math::Vector3<float>& v_N) const {
        return {v_N.x() - state_.x(), v_N.y() - state_.y(), v_N.z()};
    }
    float north() const { return state_.x(); }
    float east() const { return state_.y(); }
    float scale() const { return state_.z(); }
    float variance_north() const { return P_(0, 0); }
    float variance_east() const { return P_(1, 1); }

  private:
    bool fuse(float innovation, const math::Vector3<float>& H, float variance, float gate);

    bool is_running_ = false;
    math::Vector3<float> state_ = {0.0F, 0.0F, 1.0F};
    math::Matrix3<float> P_ = math::Matrix3<float>::Zero();
};

}  // namespace stator::apps::airspeed_selector
