// Finds the motor that thrusts no more.
#pragma once

#include <optional>

#include "rotors.hpp"

namespace stator::apps::motor_loss {

// An observer of the body rate that knows the commands: what it must add so as to follow the gyro
// is the torque that is missing. It points away from one rotor, and the accelerometer misses the
// thrust of one rotor, too: what the ground or a gust does looks otherwise.
//
//     rate' = gyration^-2 (torque of the commands - rate x gyration^2 rate) + residual
//     residual = kFollow (measured rate - rate)
class MotorWatch {
  public:
    // `hover_thrust`: of all rotors together, 0 to 1.
    void restart(float hover_thrust);
    // A gyro sample, the specific force along -z of B, and the commands: those of `dt` ago count.
    void update(const Quad& quad, const Vector3& rate_B, float lift, const Commands& commands,
                float dt);
    // Looks for a lost motor while the vehicle flies.
    std::optional<unsigned> lost(const Quad& quad, float dt);
    // Specific force of a rotor at full thrust, m/s^2.
    float force_per_command() const { return force_per_command_; }
    bool carries() const { return carries_; }  // thrust for the weight

  private:
    bool lacks(const Quad& quad, unsigned rotor) const;

    Commands acting_{};  // the commands behind the rotors' lag
    Vector2 rate_ = Vector2::Zero();
    Vector2 residual_ = Vector2::Zero();  // rad/s^2, about x and y
    float lift_ = 0.0F;
    float sum_ = 0.0F;
    float force_per_command_ = 0.0F;
    bool carries_ = false;
    unsigned suspect_ = 0;
    float suspected_s_ = 0.0F;
};

}  // namespace stator::apps::motor_loss
