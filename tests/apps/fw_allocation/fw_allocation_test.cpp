// Control surfaces: of an aeroplane with ailerons, elevator and rudder, and of a flying wing.
#include "fw_allocation.hpp"

#include <gtest/gtest.h>

#include "stator/testing.hpp"

namespace stator::apps::fw_allocation {
namespace {

constexpr float kNaN = math::canonical_nan<float>();

// Aileron, elevator, rudder, flap of the Ultra Stick 25e, whose positive deflections roll left,
// pitch down and yaw left: coefficient x 25 deg x span or chord.
FwAllocationParams ultra_stick() {
    FwAllocationParams params{};
    params.motor_count = 1;
    params.surface_count = 4;
    params.surface0_roll = -0.0912F;
    params.surface0_yaw = 0.0318F;
    params.surface1_pitch = -0.0926F;
    params.surface2_yaw = -0.1004F;
    return params;
}

class FwAllocationTest : public ::testing::Test {
  protected:
    FwAllocationTest() { status_.arming_state = VehicleStatus::ArmingState::kArmed; }
    void step(std::array<float, 3> torque) {
        torque_.xyz = torque;
        FwAllocationPorts ports{.now = 1000,
                                .torque = Input(torque_),
                                .thrust = Input(thrust_),
                                .status = Input(status_),
                                .params = Input(params_, true)};
        testing::Probe servos(ports.servos, 0);
        testing::Probe motors(ports.motors, 0);
        node_.step(ports);
        servos_ = servos.newest().control;
        motors_ = motors.newest().control;
    }

    FwAllocation node_;
    FwAllocationParams params_ = ultra_stick();
    VehicleTorqueSetpoint torque_{};
    VehicleThrustSetpoint thrust_{.xyz = {0.6F, 0.0F, 0.0F}};
    VehicleStatus status_{};
    std::array<float, 8> servos_{};
    std::array<float, 12> motors_{};
};

TEST_F(FwAllocationTest, EachAxisHasItsSurface) {
    step({0.5F, 0.0F, 0.0F});
    EXPECT_NEAR(servos_[0], -0.5F, 1e-5F);
    EXPECT_NEAR(servos_[1], 0.0F, 1e-5F);
    step({0.0F, 0.5F, 0.0F});
    EXPECT_NEAR(servos_[1], -0.5F, 1e-5F);
    EXPECT_NEAR(servos_[0], 0.0F, 1e-5F);
    EXPECT_NEAR(servos_[3], 0.0F, 1e-5F);  // the flap
    EXPECT_EQ(motors_[0], 0.6F);
    EXPECT_TRUE(math::is_nan(motors_[1]));
    EXPECT_TRUE(math::is_nan(servos_[4]));
}

// The yaw of the ailerons is taken away by the rudder: 0.5 x 0.0318 / 0.1004 = 0.158.
TEST_F(FwAllocationTest, TheRudderTakesAwayWhatTheAileronsYaw) {
    step({0.5F, 0.0F, 0.0F});
    EXPECT_NEAR(servos_[2], -0.158F, 1e-3F);
}

// Elevons of the Skywalker X8: each rolls and pitches, and there is no rudder.
TEST_F(FwAllocationTest, ElevonsShareRollAndPitch) {
    params_ = {};
    params_.motor_count = 1;
    params_.surface_count = 2;
    params_.surface0_roll = -0.044F;
    params_.surface0_pitch = -0.0125F;
    params_.surface1_roll = 0.044F;
    params_.surface1_pitch = -0.0125F;
    step({0.4F, 0.0F, 1.0F});
    EXPECT_NEAR(servos_[0], -0.4F, 1e-5F);
    EXPECT_NEAR(servos_[1], 0.4F, 1e-5F);
    step({0.4F, 0.4F, 0.0F});
    EXPECT_NEAR(servos_[0], -0.8F, 1e-5F);
    EXPECT_NEAR(servos_[1], 0.0F, 1e-5F);
    step({1.0F, 1.0F, 0.0F});
    EXPECT_EQ(servos_[0], -1.0F);
}

TEST_F(FwAllocationTest, DisarmedMotorsStopAndServosAreNeutral) {
    status_.arming_state = VehicleStatus::ArmingState::kDisarmed;
    step({0.5F, 0.0F, 0.0F});
    EXPECT_TRUE(math::is_nan(motors_[0]));
    EXPECT_TRUE(math::is_nan(servos_[0]));
}

TEST_F(FwAllocationTest, WhatIsNotANumberReadsAsZero) {
    thrust_.xyz[0] = kNaN;
    step({kNaN, 0.5F, 0.0F});
    EXPECT_NEAR(servos_[0], 0.0F, 1e-5F);
    EXPECT_NEAR(servos_[1], -0.5F, 1e-5F);
    EXPECT_EQ(motors_[0], 0.0F);
}

}  // namespace
}  // namespace stator::apps::fw_allocation
