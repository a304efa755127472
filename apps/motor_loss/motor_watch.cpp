// Finds the motor that thrusts no more.
#include "motor_watch.hpp"

namespace stator::apps::motor_loss {

namespace {

constexpr float kGravity = 9.80665F;
constexpr float kLag = 0.02F;      // s, of rotors: between those that speed up and that slow down
constexpr float kFollow = 60.0F;   // 1/s
constexpr float kShake = 0.02F;    // s, against vibration
constexpr float kLearning = 3.0F;  // s, a battery sags more slowly
constexpr float kCarries = 0.8F;   // of the weight
constexpr float kTells = 0.15F;    // a rotor at less shows little
// Parts of a rotor's share. Wind through the rotors changes the force of all of them alike.
constexpr float kLeastTorque = 0.5F;
constexpr float kLeastForce = 0.35F;
constexpr float kMostForce = 2.0F;
constexpr float kLearns = 0.25F;
constexpr float kLasts = 0.02F;  // s

}  // namespace

void MotorWatch::restart(float hover_thrust) {
    *this = MotorWatch();
    lift_ = kGravity;
    force_per_command_ = kGravity / (static_cast<float>(kRotors) * hover_thrust);
}

void MotorWatch::update(const Quad& quad, const Vector3& rate_B, float lift,
                        const Commands& commands, float dt) {
    Vector2 torque = Vector2::Zero();
    sum_ = 0.0F;
    for (unsigned i = 0; i < kRotors; ++i) {
        acting_[i] += (commands[i] - acting_[i]) * dt / (kLag + dt);
        torque += quad.arm(i) * (acting_[i] * force_per_command_);
        sum_ += acting_[i];
    }
    lift_ += (lift - lift_) * dt / (kShake + dt);
    carries_ = sum_ * force_per_command_ > kCarries * kGravity;
    const Vector2 free = torque - quad.gyroscopic(rate_B);
    rate_ += (free.cwiseQuotient(quad.gyration2.head<2>()) + residual_) * dt;
    const float gain = kFollow / (1.0F + kFollow * dt);
    residual_ = (rate_B.head<2>() - rate_) * gain;
    const float missing = sum_ * force_per_command_ - lift_;
    if (carries_ && math::abs(missing) < kLearns * force_per_command_)
        force_per_command_ += (lift_ / sum_ - force_per_command_) * dt / kLearning;
}

// Whether this rotor alone explains what is missing.
bool MotorWatch::lacks(const Quad& quad, unsigned rotor) const {
    const float share = acting_[rotor] * force_per_command_;
    if (acting_[rotor] < kTells) return false;
    const Vector2 gives = quad.arm(rotor).cwiseQuotient(quad.gyration2.head<2>()) * share;
    const float along = -residual_.dot(gives) / gives.squaredNorm();
    const Vector2 rest = residual_ + gives * along;
    const float force = (sum_ * force_per_command_ - lift_) / share;
    return along > kLeastTorque && rest.squaredNorm() < (gives * along).squaredNorm() &&
           force > kLeastForce && force < kMostForce;
}

std::optional<unsigned> MotorWatch::lost(const Quad& quad, float dt) {
    for (unsigned i = 0; i < kRotors; ++i) {
        if (!lacks(quad, i)) continue;
        suspected_s_ = suspect_ == i ? suspected_s_ + dt : dt;
        suspect_ = i;
        if (suspected_s_ < kLasts) return std::nullopt;
        return i;
    }
    suspected_s_ = 0.0F;
    return std::nullopt;
}

}  // namespace stator::apps::motor_loss
