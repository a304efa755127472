// The error-state Kalman filter: what it believes, how sure it is, and its two operations.
#pragma once

#include "covariance.hpp"
#include "motion_window.hpp"
#include "navigation_ports.hpp"

namespace stator::apps::navigation {

inline constexpr float kGravity = 9.80665F;  // m/s^2, standard

struct Kinematics {
    Quaternion q_NB = Quaternion::Identity();
    Vector velocity_N = Vector::Zero();
    Vector position_N = Vector::Zero();
};

// Where `start` gets to by `motion`.
Kinematics moved(const Kinematics& start, const Motion& motion);

// How a measurement went.
struct Fusion {
    float innovation = 0.0F;
    float test_ratio = 0.0F;  // innovation^2 over what the gate allows: fused up to 1
    bool fused() const { return test_ratio <= 1.0F; }
};

class Filter {
  public:
    const Kinematics& kinematics() const { return kinematics_; }
    const ImuBias& bias() const { return bias_; }
    float baro_offset() const { return baro_offset_; }
    float mag_offset() const { return mag_offset_; }
    const Covariance& covariance() const { return covariance_; }
    float variance(unsigned state) const { return covariance_(state, state); }
    uint64_t time_us() const { return time_us_; }
    // Of the last step, in N: for measurements made within it.
    const Vector& acceleration_N() const { return acceleration_N_; }
    float heading_rate() const { return heading_rate_; }
    bool is_finite() const;
    // A bias has reached what no sensor in order has: something else is wrong, and the tilt with
    // it.
    bool has_impossible_bias() const;
    bool has_impossible_accel_bias() const;

    // At rest at the origin, with this attitude and this uncertainty of its tilt.
    void start(uint64_t time_us, const Quaternion& q_NB, float tilt_variance,
               float heading_variance, const NavigationParams& params);
    // What is felt may be wrong by `force_error`, m/s^2.
    void predict(const MotionWindow::Step& step, const NavigationParams& params,
                 float force_error = 0.0F);
    // Fuses one scalar whose innovation and noise variance these are, if it passes the gate.
    Fusion fuse(const ObservationModel& model, float innovation, float variance, float gate,
                bool keep_tilt = false);

    // Replace an estimate and its variance, whatever they were.
    void set_horizontal_velocity(const Eigen::Vector2f& velocity, float variance);
    void set_vertical_velocity(float velocity, float variance);
    void set_horizontal_position(const Eigen::Vector2f& position, float variance);
    void set_down(float down, float variance);
    // Turns by the error that the magnetometer shows, which is known as well as its offset.
    void align_heading(float error, float noise_variance, float offset_variance);
    // Something was wrong with the inertial sensors: tilt and biases may be, too.
    void forget_inertial_errors();
    // It was no bias, and tilt, heading and the gyro's bias were found with it.
    void forget_accel_bias();
    void shift_mag_offset(float change, float variance);
    // Trusts neither the heading nor the magnetometer's offset any more, only their sum.
    void inflate_heading_variance(float variance) {
        covariance_.loosen(kHeading, kMagOffset, variance);
    }

  private:
    void inject(const Covariance::Column& error, bool keep_tilt);

    Kinematics kinematics_;
    ImuBias bias_;
    float baro_offset_ = 0.0F;  // m, what the barometer's height reads too much
    float mag_offset_ = 0.0F;   // rad, what the magnetic heading error reads too much
    Covariance covariance_;
    Vector acceleration_N_ = Vector::Zero();
    float heading_rate_ = 0.0F;
    Eigen::Vector2f level_force_N_ = Eigen::Vector2f::Zero();  // low-passed
    uint64_t time_us_ = 0;
};

}  // namespace stator::apps::navigation
