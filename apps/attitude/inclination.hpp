// Where down is: the strapdown's frame I, and its turn to a level frame T.
//
// I is where the integrated gyro says that the vehicle started; it moves only as fast as the gyro's
// bias makes it. Accelerations of a vehicle that stays in one region average out in a frame that
// does not turn, and gravity stays: so the specific force is low-passed in I, and T is the frame
// whose z axis lies along it. The heading of T is arbitrary, and no correction changes it.
#pragma once

#include "low_pass.hpp"
#include "stator/rotation.hpp"

namespace stator::apps::attitude {

class Inclination {
  public:
    using Vector = math::Vector3<float>;
    using Quaternion = math::Quaternion<float>;

    Quaternion q_TB() const { return q_TI_ * q_IB_; }

    // Integrates the body rate over the time `dt`.
    void turn(const Vector& rate_B, float dt) { q_IB_ = math::integrate(q_IB_, rate_B, dt); }

    // Takes a sample of the specific force in.
    void feel(const Vector& force_B) { felt_I_.add(q_IB_ * force_B); }

    // Corrects with the mean of the samples of the last `dt` seconds, one at least. Returns how far
    // the estimate had turned away since the correction before, about T's first two axes, in
    // radians; zero if gravity was just found.
    Eigen::Vector2f correct(float dt, float time_constant);

    // Finds gravity again, as at the start.
    void restart() {
        felt_I_ = Average();
        force_I_.restart();
    }

  private:
    Quaternion q_IB_ = Quaternion::Identity();
    Quaternion q_TI_ = Quaternion::Identity();
    Average felt_I_;
    LowPass<Vector> force_I_;
};

}  // namespace stator::apps::attitude
