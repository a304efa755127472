// By how much the sensors disagree with the estimate for longer than their noise explains.
#pragma once

#include "motion.hpp"

namespace stator::apps::navigation {

// Low-passed innovations, of measurements that were fused and of those that were left out, and what
// the estimate was moved by where one of two contradicting sources was believed. The filter's
// variance knows nothing of either; what the output says of its error contains both.
struct Disagreement {
    Vector velocity_N = Vector::Zero();
    Vector position_N = Vector::Zero();  // down: satellites against the estimate
    float baro = 0.0F;
    float baro_velocity = 0.0F;  // down
    float heading = 0.0F;
    Vector jump_N = Vector::Zero();
    float heading_jump = 0.0F;

    static void follow(float& mean, float innovation, float part) {
        mean += part * (innovation - mean);
    }

    void follow_jump(const Eigen::Vector2f& receiver_N, float part) {
        jump_N.head<2>() += part * (receiver_N - jump_N.head<2>());
    }

    // Variances to add.
    float level_velocity() const { return velocity_N.head<2>().squaredNorm(); }
    float vertical_velocity() const { return math::square(velocity_N.z()); }
    float level_position() const {
        return position_N.head<2>().squaredNorm() +
               math::square(kJump) * jump_N.head<2>().squaredNorm();
    }
    // A receiver's height is off by metres for minutes: only half of it counts.
    float height() const {
        return math::square(0.5F * position_N.z()) + math::square(baro) +
               math::square(kJump * jump_N.z());
    }
    float nose() const { return math::square(heading) + math::square(kJump * heading_jump); }

  private:
    static constexpr float kJump = 1.0F / 3.0F;
};

}  // namespace stator::apps::navigation
