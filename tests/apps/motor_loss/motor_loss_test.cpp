// A quadrotor that loses a motor: which one, how soon, and how it flies on.
#include "motor_loss.hpp"

#include <gtest/gtest.h>

#include "stator/testing.hpp"

namespace stator::apps::motor_loss {
namespace {

constexpr float kGravity = 9.80665F;
constexpr float kForce = kGravity / (4.0F * 0.5328F);  // m/s^2 of a rotor at full thrust

// A rigid body with four rotors that follow their commands with a lag, and one motor that may fail.
// It flies by a simple cascade until another takes over.
class MotorLossTest : public ::testing::Test {
  protected:
    static constexpr float kStep = 0.001F;
    static constexpr float kHover = 0.5328F;
    const std::array<Vector2, 4> place_{Vector2(0.13F, 0.22F), Vector2(-0.13F, -0.2F),
                                        Vector2(0.13F, -0.22F), Vector2(-0.13F, 0.2F)};
    const Vector3 gyration2_{0.01897F, 0.01897F, 0.03598F};

    MotorLossTest() {
        status_.arming_state = VehicleStatus::ArmingState::kArmed;
        setpoint_.q_d = {1.0F, 0.0F, 0.0F, 0.0F};
        setpoint_.thrust_body = {0.0F, 0.0F, -kHover};
    }

    void move() {
        Vector3 torque = Vector3::Zero();
        float lift = 0.0F;
        for (unsigned i = 0; i < 4; ++i) {
            const float command = i == failed_ ? health_ * commands_[i] : commands_[i];
            acting_[i] += (command - acting_[i]) * kStep / (0.02F + kStep);
            const float force = acting_[i] * kForce;
            torque += Vector3(-place_[i].y(), place_[i].x(), i < 2 ? 0.06F : -0.06F) * force;
            lift += force;
        }
        torque.z() -= 0.021F * rate_.z();  // the rotors' drag where they go round the centre
        torque += push_;
        const Vector3 momentum = gyration2_.cwiseProduct(rate_);
        rate_ += (torque - rate_.cross(momentum)).cwiseQuotient(gyration2_) * kStep;
        q_ = math::normalized(q_ * math::from_rotation_vector(Vector3(rate_ * kStep)));
        lift_ = lift;
    }

    // As rate control and allocation would, while all motors thrust.
    void steer() {
        const Vector3 down = q_.conjugate() * Vector3(0.0F, 0.0F, 1.0F);
        const Vector3 wanted(7.0F * -down.y(), 7.0F * down.x(), 0.0F);
        const Vector3 torque = 20.0F * gyration2_.cwiseProduct(wanted - rate_) / kForce;
        for (unsigned i = 0; i < 4; ++i) {
            const float level = -place_[i].y() * torque.x() / (4.0F * 0.0442F) +
                                place_[i].x() * torque.y() / (4.0F * 0.0169F);
            commands_[i] = math::clamp(kHover + level, 0.02F, 1.0F);
        }
    }

    void run(float seconds) {
        for (float t = 0.0F; t < seconds; t += kStep) {
            move();
            if (!is_lost()) steer();
            if (++ticks_ % 4 == 0) step();
            highest_tilt_ = std::max(highest_tilt_, tilt());
        }
    }

    void step() {
        now_us_ += 4'000;
        gyro_.timestamp_sample = now_us_;
        gyro_.xyz = math::to_array(rate_);
        accel_.xyz = {0.0F, 0.0F, -lift_};
        attitude_.q = math::to_array(q_);
        for (unsigned i = 0; i < 4; ++i) motors_.control[i] = commands_[i];
        MotorLossPorts ports{.now = now_us_,
                             .gyro = Input(gyro_),
                             .accel = Input(accel_),
                             .motors = Input(motors_),
                             .attitude = Input(attitude_),
                             .setpoint = Input(setpoint_),
                             .status = Input(status_),
                             .params = Input(params_)};
        testing::Probe failure(ports.failure, now_us_);
        testing::Probe left(ports.motors_left, now_us_);
        node_.step(ports);
        if (failure.count() != 0) mask_ = failure.newest().motor_failure_mask;
        commanded_ = left.count() != 0;
        if (!commanded_) return;
        for (unsigned i = 0; i < 4; ++i) {
            const float control = left.newest().control[i];
            commands_[i] = math::is_finite(control) ? control : 0.0F;
        }
    }

    bool is_lost() const { return mask_ != 0; }
    float tilt() const {
        return std::acos(std::clamp((q_ * Vector3(0.0F, 0.0F, 1.0F)).z(), -1.0F, 1.0F));
    }
    void fail(unsigned motor, float health = 0.0F) {
        failed_ = motor;
        health_ = health;
    }

    MotorLoss node_;
    SensorGyro gyro_{};
    SensorAccel accel_{};
    ActuatorMotors motors_{};
    VehicleAttitude attitude_{};
    VehicleAttitudeSetpoint setpoint_{};
    VehicleStatus status_{};
    MotorLossParams params_{};
    uint64_t now_us_ = 1'000'000;
    unsigned ticks_ = 0;
    Commands commands_{kHover, kHover, kHover, kHover};
    Commands acting_ = commands_;
    Vector3 rate_ = Vector3::Zero();
    Vector3 push_ = Vector3::Zero();
    math::Quaternion<float> q_ = math::Quaternion<float>::Identity();
    float lift_ = kGravity;
    float highest_tilt_ = 0.0F;
    unsigned failed_ = 4;
    float health_ = 0.0F;
    unsigned mask_ = 0;
    bool commanded_ = false;
};

TEST_F(MotorLossTest, SaysNothingWhileAllMotorsThrust) {
    run(5.0F);
    EXPECT_EQ(mask_, 0U);
    EXPECT_FALSE(commanded_);
}

TEST_F(MotorLossTest, FindsTheMotorWithinATenthOfASecond) {
    for (unsigned motor = 0; motor < 4; ++motor) {
        SetUp();
        node_ = MotorLoss();
        mask_ = 0;
        fail(4);
        rate_.setZero();
        q_.setIdentity();
        commands_ = acting_ = {kHover, kHover, kHover, kHover};
        run(2.0F);
        ASSERT_EQ(mask_, 0U);
        fail(motor);
        run(0.1F);
        EXPECT_EQ(mask_, 1U << motor);
    }
}

TEST_F(MotorLossTest, FliesOnUprightAndSpins) {
    run(2.0F);
    fail(0);
    run(1.5F);
    EXPECT_LT(highest_tilt_, 1.2F);
    highest_tilt_ = 0.0F;
    run(10.0F);
    EXPECT_LT(highest_tilt_, 0.3F);
    EXPECT_LT(rate_.z(), -10.0F);
    EXPECT_NEAR(lift_, kGravity, 0.05F * kGravity);
    EXPECT_EQ(commands_[0], 0.0F);
}

TEST_F(MotorLossTest, LeansTowardsTheSetpoint) {
    run(2.0F);
    fail(2);
    run(5.0F);
    setpoint_.q_d = math::to_array(math::from_euler(math::EulerAngles<float>{0.2F, 0.0F, 0.0F}));
    run(2.0F);
    Vector3 mean = Vector3::Zero();
    for (int i = 0; i < 1000; ++i) {
        run(kStep);
        mean += q_ * Vector3(0.0F, 0.0F, 1.0F) / 1000.0F;
    }
    EXPECT_NEAR(mean.y(), -math::sincos(0.2F).sin, 0.05F);
    EXPECT_NEAR(mean.x(), 0.0F, 0.05F);
}

TEST_F(MotorLossTest, AHalfLostMotorCountsAndAWeakOneDoesNot) {
    run(2.0F);
    fail(1, 0.8F);
    run(3.0F);
    EXPECT_EQ(mask_, 0U);
    fail(1, 0.2F);
    run(0.2F);
    EXPECT_EQ(mask_, 2U);
}

// A push that turns the vehicle takes no thrust away.
TEST_F(MotorLossTest, ATorqueFromOutsideIsNoLostMotor) {
    run(2.0F);
    push_ = Vector3(0.4F, -0.24F, 0.0F);
    run(0.2F);
    push_.setZero();
    run(2.0F);
    EXPECT_EQ(mask_, 0U);
}

TEST_F(MotorLossTest, AMotorThatComesBackStaysStoppedUntilDisarmed) {
    run(2.0F);
    fail(3);
    run(2.0F);
    fail(4);
    run(2.0F);
    EXPECT_EQ(mask_, 8U);
    EXPECT_EQ(commands_[3], 0.0F);
    status_.arming_state = VehicleStatus::ArmingState::kDisarmed;
    step();
    EXPECT_FALSE(commanded_);
    now_us_ += 100'000;
    step();
    EXPECT_EQ(mask_, 0U);
}

TEST_F(MotorLossTest, WithoutASetpointItIsLevel) {
    run(2.0F);
    setpoint_.q_d[0] = math::canonical_nan<float>();
    setpoint_.thrust_body[2] = math::canonical_nan<float>();
    fail(0);
    run(5.0F);
    EXPECT_LT(tilt(), 0.3F);
    EXPECT_NEAR(lift_, kGravity, 0.05F * kGravity);
}

}  // namespace
}  // namespace stator::apps::motor_loss
