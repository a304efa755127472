// Watches the motors of a quadrotor, and flies on three of them.
#pragma once

#include <cstdint>
#include <optional>

#include "motor_loss_ports.hpp"
#include "motor_watch.hpp"
#include "three_rotors.hpp"

namespace stator::apps::motor_loss {

// Beside the cascade: silent while all motors thrust. Once one is lost its commands take the place
// of those of allocation, until the vehicle is disarmed; a motor that comes back stays stopped.
// A sample that is not a number is left out; a setpoint that is absent reads as level, with the
// thrust that it had.
class MotorLoss {
  public:
    void step(MotorLossPorts& ports);

  private:
    void watch(const MotorLossPorts& ports, const Vector3& rate_B, float dt);
    void take_setpoint(const MotorLossPorts& ports);
    void fly(MotorLossPorts& ports, const Vector3& rate_B);
    void publish_failure(MotorLossPorts& ports);

    Quad quad_{};
    MotorWatch motors_;
    ThreeRotors three_;
    std::optional<unsigned> lost_;
    bool was_armed_ = false;
    float carries_for_s_ = 0.0F;
    Vector3 down_N_ = {0.0F, 0.0F, 1.0F};  // away from the wanted thrust
    float thrust_ = 0.0F;
    uint64_t last_us_ = 0;
    uint64_t told_us_ = 0;
};

}  // namespace stator::apps::motor_loss
