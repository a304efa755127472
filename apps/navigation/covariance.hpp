// Covariance of the error state, and the three things that happen to it.
//
// The error of the estimate, true less estimated: attitude as a small turn in N, which is what the
// right-invariant filter uses (A. Barrau, S. Bonnabel, "The invariant extended Kalman filter as a
// stable observer", TAC 2017) and keeps heading and tilt apart; velocity and position in N; biases
// in B; then two slow errors of instruments.
#pragma once

#include <array>

#include "motion.hpp"

namespace stator::apps::navigation {

enum ErrorState : unsigned {
    kTurn = 0,
    kHeading = 2,  // the turn about down
    kVelocity = 3,
    kPosition = 6,
    kGyroBias = 9,
    kAccelBias = 12,
    kBaroOffset = 15,
    kMagOffset = 16,
    kStates = 17,
};

// H of a scalar measurement: one state, or the sum of two with the signs given.
struct ObservationModel {
    ErrorState first = kTurn;
    float first_sign = 1.0F;
    ErrorState second = kTurn;
    float second_sign = 0.0F;
};

class Covariance {
  public:
    // Variances added in one step.
    struct Noise {
        float turn;
        float velocity;
        float gyro_bias;
        float accel_bias;
        float baro_offset;
        float mag_offset;
    };
    using Column = std::array<float, kStates>;

    float operator()(unsigned row, unsigned column) const { return p_[row][column]; }

    // Forgets what is known of `count` states.
    void reset(unsigned first, unsigned count, float variance);
    // Level was found from the accelerometer: what is wrong with it now is its bias over gravity,
    // and `tilt_variance` of motion meanwhile. Tilt and bias together explain no acceleration.
    void level(const math::Matrix3<float>& R_NB, float gravity, float bias_variance,
               float tilt_variance);
    // Makes the difference of two states uncertain and leaves their sum as it was.
    void loosen(unsigned first, unsigned second, float variance);

    // F P F' + Q for a step of `time` in which the velocity changed by `push_N` and the body was at
    // R_NB. F differs from 1 in four blocks only, each of which is applied as a row operation and
    // its mirror image:
    //     position += time velocity
    //     velocity += -skew(push_N) turn - R_NB time accel_bias
    //     turn     += -R_NB time gyro_bias
    void predict(const math::Matrix3<float>& R_NB, const Vector& push_N, float time,
                 const Noise& noise);

    // P H', the covariance of each state with what is measured.
    Column cross_covariance(const ObservationModel& model) const;
    // Takes off what a measurement tells, with the gain cross / variance: P H' over the variance
    // of the innovation. `keep_tilt`: that gain is zero for the turns about north and east.
    void correct(const Column& cross, float variance, bool keep_tilt);

    // Keeps the variances between what float can hold apart and what linearisation allows.
    void limit();

  private:
    void transform(unsigned to, unsigned from, const math::Matrix3<float>& a);
    void drift(float time);
    void mirror(unsigned first);

    std::array<Column, kStates> p_{};
};

}  // namespace stator::apps::navigation
