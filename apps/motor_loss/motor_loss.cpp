// Watches the motors of a quadrotor, and flies on three of them.
#include "motor_loss.hpp"

#include "stator/elapsed.hpp"

namespace stator::apps::motor_loss {

namespace {

constexpr float kShortestStep = 125e-6F;
constexpr float kLongestStep = 20e-3F;
constexpr uint64_t kTellAgain_us = 100'000;
constexpr float kFlies = 1.0F;      // s of thrust that carries the weight
constexpr float kMostLean = 0.34F;  // sine; what spins leans by some degrees more

Quad quad_of(const MotorLossParams& p) {
    return {.place_B = {Vector2(p.rotor0_x, p.rotor0_y), Vector2(p.rotor1_x, p.rotor1_y),
                        Vector2(p.rotor2_x, p.rotor2_y), Vector2(p.rotor3_x, p.rotor3_y)},
            .gyration2 = {math::square(p.gyration_x), math::square(p.gyration_y),
                          math::square(p.gyration_z)}};
}

bool is_armed(const MotorLossPorts& ports) {
    return ports.status && ports.status->arming_state == VehicleStatus::ArmingState::kArmed;
}

// What stands still thrusts nothing.
Commands commands_of(const MotorLossPorts& ports) {
    Commands commands{};
    for (unsigned i = 0; i < kRotors; ++i) {
        const float control = ports.motors ? ports.motors->control[i] : 0.0F;
        commands[i] = math::is_finite(control) ? control : 0.0F;
    }
    return commands;
}

Vector3 with_limited_lean(const Vector3& down) {
    Vector2 level = down.head<2>();
    const float length = math::norm(level);
    if (length > kMostLean) level *= kMostLean / length;
    return {level.x(), level.y(), math::sqrt(1.0F - level.squaredNorm())};
}

}  // namespace

void MotorLoss::watch(const MotorLossPorts& ports, const Vector3& rate_B, float dt) {
    motors_.update(quad_, rate_B, -ports.accel->xyz[2], commands_of(ports), dt);
    carries_for_s_ = motors_.carries() ? math::min(carries_for_s_ + dt, kFlies) : 0.0F;
    if (lost_) return;
    const bool flies = ports.land ? !ports.land->landed : carries_for_s_ >= kFlies;
    if (!flies) return;
    lost_ = motors_.lost(quad_, dt);
    if (lost_) three_.configure(quad_, *lost_);
    told_us_ = lost_ ? 0 : told_us_;
}

void MotorLoss::take_setpoint(const MotorLossPorts& ports) {
    down_N_ = Vector3(0.0F, 0.0F, 1.0F);
    if (!ports.setpoint || !math::is_finite(ports.setpoint->thrust_body[2])) return;
    thrust_ = math::clamp(-ports.setpoint->thrust_body[2], 0.0F, 1.0F);
    const auto q_d = math::quaternion(ports.setpoint->q_d);
    if (math::is_finite(q_d.squaredNorm()))
        down_N_ = with_limited_lean(q_d * Vector3(0.0F, 0.0F, 1.0F));
}

void MotorLoss::fly(MotorLossPorts& ports, const Vector3& rate_B) {
    if (!ports.attitude) return;
    const MotorLossParams& params = *ports.params;
    const auto& attitude = ports.navigation ? *ports.navigation : *ports.attitude;
    const auto q_NB = math::quaternion(attitude.q);
    const Vector3 down_B = q_NB.conjugate() * down_N_;
    const ThreeRotors::Gains gains{params.tilt_p, params.rate_p, params.rotor_lag};
    const Commands left =
        three_.update(quad_, gains, down_B, rate_B, thrust_, motors_.force_per_command());
    ActuatorMotors command{.timestamp_sample = ports.gyro->timestamp_sample};
    command.control.fill(math::canonical_nan<float>());
    for (unsigned i = 0; i < kRotors; ++i) command.control[i] = left[i];
    ports.motors_left.publish([&] { return command; });
}

void MotorLoss::publish_failure(MotorLossPorts& ports) {
    if (told_us_ != 0 && ports.now - told_us_ < kTellAgain_us) return;
    told_us_ = ports.now;
    const auto mask = static_cast<uint16_t>(lost_ ? 1U << *lost_ : 0U);
    ports.failure.publish([&] { return FailureDetectorStatus{.motor_failure_mask = mask}; });
}

void MotorLoss::step(MotorLossPorts& ports) {
    if (ports.params.is_new()) quad_ = quad_of(*ports.params);
    if (!ports.gyro || !ports.accel) return;
    const Vector3 rate_B = math::vector(ports.gyro->xyz);
    if (!math::is_finite(rate_B.sum() + ports.accel->xyz[2])) return;
    const float dt =
        seconds_since_last(last_us_, ports.gyro->timestamp_sample, kShortestStep, kLongestStep);
    const bool armed = is_armed(ports);
    if (!armed || !was_armed_) {
        motors_.restart(ports.params->hover_thrust);
        lost_.reset();
        carries_for_s_ = 0.0F;
    }
    was_armed_ = armed;
    if (armed) watch(ports, rate_B, dt);
    take_setpoint(ports);
    if (lost_) fly(ports, rate_B);
    publish_failure(ports);
}

}  // namespace stator::apps::motor_loss
