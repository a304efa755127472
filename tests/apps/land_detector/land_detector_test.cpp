// Landed or not: what says so, and what does not.
#include "land_detector.hpp"

#include <gtest/gtest.h>

#include "stator/testing.hpp"

namespace stator::apps::land_detector {
namespace {

class LandDetectorTest : public ::testing::Test {
  protected:
    LandDetectorTest() {
        status_.arming_state = VehicleStatus::ArmingState::kArmed;
        position_.z_valid = position_.v_z_valid = true;
        setpoint_.velocity[2] = 0.5F;
        thrust_.xyz[2] = -0.53F;
    }

    bool step() {
        now_us_ += 4'000;
        // A live sensor has noise.
        const float noise = (now_us_ / 4'000) % 2 == 0 ? 0.001F : -0.001F;
        for (unsigned i = 0; has_noise_ && i < 3; ++i) {
            accel_.xyz[i] += noise;
            gyro_.xyz[i] += noise;
        }
        LandDetectorPorts ports{.now = now_us_,
                                .position = Input(position_),
                                .setpoint = Input(setpoint_),
                                .thrust = Input(thrust_),
                                .status = Input(status_),
                                .accel = Input(accel_),
                                .gyro = Input(gyro_),
                                .attitude = Input(attitude_),
                                .params = Input(params_)};
        testing::Probe land(ports.land, now_us_);
        node_.step(ports);
        crashed_ = land.newest().crashed;
        return land.newest().landed;
    }
    bool run(float seconds) {
        bool landed = false;
        for (float t = 0.0F; t < seconds; t += 0.004F) landed = step();
        return landed;
    }
    void fly() {
        step();
        position_.z = -2.0F;
        ASSERT_FALSE(step());
    }

    void lie(float roll) {
        attitude_.q = math::to_array(math::from_euler(math::EulerAngles<float>{roll, 0.0F, 0.0F}));
        const math::SinCos<float> turn = math::sincos(roll);
        accel_.xyz = {0.0F, -9.81F * turn.sin, -9.81F * turn.cos};
    }

    LandDetector node_;
    SensorAccel accel_{.xyz = {0.0F, 0.0F, -9.81F}};
    SensorGyro gyro_{};
    VehicleAttitude attitude_{.q = {1.0F, 0.0F, 0.0F, 0.0F}};
    bool crashed_ = false;
    bool has_noise_ = true;
    VehicleLocalPosition position_{};
    TrajectorySetpoint setpoint_{};
    VehicleThrustSetpoint thrust_{};
    VehicleStatus status_{};
    LandDetectorParams params_{};
    uint64_t now_us_ = 0;
};

TEST_F(LandDetectorTest, disarmed_it_has_landed_wherever_it_is) {
    fly();
    status_.arming_state = VehicleStatus::ArmingState::kDisarmed;
    EXPECT_TRUE(step());
}

TEST_F(LandDetectorTest, armed_it_stands_until_it_is_higher_or_moves) {
    EXPECT_TRUE(run(5.0F));
    position_.z = -0.3F;
    EXPECT_TRUE(step());
    position_.vz = -1.0F;
    EXPECT_FALSE(step());
}

TEST_F(LandDetectorTest, an_estimate_that_drifts_is_no_flight) {
    thrust_.xyz[2] = -0.1F;
    step();
    for (float z = 0.0F; z > -5.0F; z -= 0.01F) {
        position_.z = z;
        position_.vz = -0.7F;
        ASSERT_TRUE(step());
    }
    position_.vz = 0.0F;
    thrust_.xyz[2] = -0.5F;  // and counts from where it has got
    EXPECT_TRUE(run(1.0F));
}

TEST_F(LandDetectorTest, has_landed_where_light_thrust_and_no_sinking_last) {
    fly();
    thrust_.xyz[2] = -0.2F;
    EXPECT_FALSE(run(0.3F));
    EXPECT_TRUE(run(0.2F));
}

TEST_F(LandDetectorTest, flies_while_one_of_these_is_missing) {
    fly();
    EXPECT_FALSE(run(2.0F));  // thrust carries it
    thrust_.xyz[2] = -0.2F;
    position_.vz = 0.5F;
    EXPECT_FALSE(run(2.0F));  // it sinks
    position_.vz = 0.0F;
    setpoint_.velocity[2] = 0.0F;
    thrust_.xyz[2] = -0.3F;
    EXPECT_FALSE(run(2.0F));  // it need not sink, and the thrust is not so little
    setpoint_.velocity[2] = 0.5F;
    setpoint_.acceleration[2] = -1.0F;
    EXPECT_FALSE(run(2.0F));  // it is still braking
    setpoint_.acceleration[2] = 0.0F;
    position_.v_z_valid = false;
    EXPECT_FALSE(run(2.0F));  // nobody knows
}

TEST_F(LandDetectorTest, after_an_impact_it_has_landed_sooner_even_with_thrust) {
    fly();
    position_.az = -12.0F;
    EXPECT_FALSE(step());
    position_.az = 0.0F;
    EXPECT_TRUE(run(0.08F));
}

TEST_F(LandDetectorTest, a_jolt_high_up_is_a_gust) {
    fly();
    position_.z = -20.0F;
    step();
    position_.az = -12.0F;
    EXPECT_FALSE(step());
    position_.az = 0.0F;
    EXPECT_FALSE(run(0.3F));
}

TEST_F(LandDetectorTest, an_impact_that_is_long_past_does_not_count) {
    fly();
    position_.vz = 0.5F;
    position_.az = -12.0F;
    step();
    position_.az = 0.0F;
    run(0.6F);
    position_.vz = 0.0F;
    EXPECT_FALSE(run(0.3F));
}

TEST_F(LandDetectorTest, what_only_seemed_to_have_landed_flies_as_soon_as_it_falls) {
    fly();
    thrust_.xyz[2] = -0.2F;
    ASSERT_TRUE(run(0.5F));
    position_.vz = 0.7F;
    EXPECT_TRUE(step());
    position_.az = 5.0F;
    EXPECT_FALSE(step());
}

TEST_F(LandDetectorTest, without_a_sinking_setpoint_it_lands_after_a_while_with_hardly_any_thrust) {
    fly();
    setpoint_.velocity[2] = math::canonical_nan<float>();
    thrust_.xyz[2] = -0.1F;
    EXPECT_FALSE(run(0.9F));
    EXPECT_TRUE(run(0.2F));
}

TEST_F(LandDetectorTest, what_falls_has_not_landed) {
    fly();
    setpoint_.velocity[2] = 0.0F;
    thrust_.xyz[2] = -0.1F;
    position_.az = 5.0F;
    EXPECT_FALSE(run(3.0F));
}

TEST_F(LandDetectorTest, without_a_height_an_impact_in_a_descent_and_rest_after_it_count) {
    fly();
    position_.z_valid = position_.v_z_valid = false;
    status_.nav_state = VehicleStatus::NavState::kDescend;
    EXPECT_FALSE(run(3.0F));
    accel_.xyz[2] = -25.0F;
    EXPECT_FALSE(step());
    accel_.xyz[2] = -9.81F;
    EXPECT_FALSE(run(0.4F));
    EXPECT_TRUE(run(0.4F));
}

// It slides along the ground, and comes to rest.
TEST_F(LandDetectorTest, rest_counts_for_some_seconds_after_an_impact) {
    fly();
    position_.z_valid = position_.v_z_valid = false;
    status_.nav_state = VehicleStatus::NavState::kDescend;
    run(3.0F);
    accel_.xyz[2] = -25.0F;
    step();
    accel_.xyz[2] = -9.81F;
    gyro_.xyz[2] = 0.5F;
    EXPECT_FALSE(run(3.0F));
    gyro_.xyz[2] = 0.0F;
    EXPECT_TRUE(run(0.6F));
}

TEST_F(LandDetectorTest, it_has_crashed_when_it_lies_upside_down_or_on_its_side) {
    for (const float roll : {1.57F, 3.1F, -1.6F}) {
        node_ = {};
        position_.z = 0.0F;
        lie(0.0F);
        fly();
        lie(roll);
        run(0.6F);
        EXPECT_FALSE(crashed_);
        run(0.6F);
        EXPECT_TRUE(crashed_) << roll;
        status_.arming_state = VehicleStatus::ArmingState::kDisarmed;
        step();
        EXPECT_FALSE(crashed_);
        status_.arming_state = VehicleStatus::ArmingState::kArmed;
    }
}

TEST_F(LandDetectorTest, what_flies_tilted_or_tumbles_has_not_crashed) {
    fly();
    lie(3.1F);
    accel_.xyz = {0.0F, 0.0F, -9.81F};  // its own thrust
    gyro_.xyz = {0.5F, 0.0F, 0.0F};     // with which it turns back
    run(3.0F);
    EXPECT_FALSE(crashed_);
    gyro_ = {};  // what does not turn does not fly
    run(1.6F);
    EXPECT_TRUE(crashed_);
    lie(0.0F);
    step();
    lie(3.1F);
    gyro_.xyz = {4.0F, 0.0F, 0.0F};
    run(3.0F);
    EXPECT_FALSE(crashed_);
    lie(0.0F);
    gyro_ = {};
    accel_.xyz = {0.0F, 0.0F, 9.81F};  // a sensor that is wrong, or an attitude
    run(2.5F);
    EXPECT_FALSE(crashed_);
    run(1.0F);
    EXPECT_TRUE(crashed_);
}

// A gyro that clips at a slow rate turns, too: it repeats itself.
TEST_F(LandDetectorTest, a_tumble_under_a_clipped_gyro_is_a_crash) {
    fly();
    const auto clipped = [this](bool clips, float seconds) {
        for (float t = 0.0F; t < seconds; t += 0.004F) {
            const float noise = (now_us_ + 4'000) / 4'000 % 2 == 0 ? 0.001F : -0.001F;
            gyro_.xyz = {0.0F, clips ? 0.5F - noise : 0.05F, 0.0F};
            accel_.xyz[2] = -0.57F - noise;
            step();
        }
    };
    clipped(false, 4.0F);
    EXPECT_FALSE(crashed_);
    clipped(true, 0.7F);
    clipped(false, 1.6F);
    EXPECT_TRUE(crashed_);
}

// Of a gyro that has drifted away; the attitude, too, is wrong.
TEST_F(LandDetectorTest, a_steady_rate_does_not_hide_a_crash) {
    fly();
    accel_.xyz = {0.0F, 0.0F, 9.81F};
    gyro_.xyz = {1.0F, 1.0F, 1.0F};
    run(3.0F);
    EXPECT_FALSE(crashed_);
    run(1.0F);
    EXPECT_TRUE(crashed_);
}

// Whatever turns it: nothing flies upside down for so long.
TEST_F(LandDetectorTest, what_stays_upside_down_has_crashed) {
    fly();
    lie(3.1F);
    gyro_.xyz = {4.0F, 0.0F, 0.0F};
    run(3.8F);
    EXPECT_FALSE(crashed_);
    run(0.4F);
    EXPECT_TRUE(crashed_);
}

// Gyro and accelerometer that repeat themselves keep nothing in the air.
TEST_F(LandDetectorTest, without_an_imu_it_has_crashed_after_a_while) {
    fly();
    run(5.0F);
    EXPECT_FALSE(crashed_);
    has_noise_ = false;
    run(1.8F);
    EXPECT_FALSE(crashed_);
    run(0.4F);
    EXPECT_TRUE(crashed_);
}

// An accelerometer at the end of its range: what tumbled and turns no more lies there.
TEST_F(LandDetectorTest, a_tumble_that_ends_under_a_clipped_accelerometer_is_a_crash) {
    fly();
    const auto clipped = [this](float rate, float seconds) {
        for (float t = 0.0F; t < seconds; t += 0.004F) {
            gyro_.xyz = {rate, 0.0F, 0.0F};
            accel_.xyz[2] = -0.7F - ((now_us_ + 4'000) / 4'000 % 2 == 0 ? 0.001F : -0.001F);
            step();
        }
    };
    clipped(0.0F, 4.0F);
    EXPECT_FALSE(crashed_);
    clipped(0.7F, 0.6F);
    EXPECT_FALSE(crashed_);
    clipped(0.05F, 1.6F);
    EXPECT_TRUE(crashed_);
}

TEST_F(LandDetectorTest, what_feels_its_weight_without_thrust_is_carried) {
    fly();
    thrust_.xyz[2] = -0.15F;
    position_.vz = 1.2F;  // an estimate that drifts
    EXPECT_FALSE(run(4.8F));
    EXPECT_TRUE(run(0.4F));
}

// A vehicle that leans into a storm feels much, but steadily.
TEST_F(LandDetectorTest, a_strong_steady_force_is_no_impact) {
    fly();
    position_.z_valid = position_.v_z_valid = false;
    status_.nav_state = VehicleStatus::NavState::kDescend;
    run(3.0F);
    for (float force = 9.8F; force < 18.0F; force += 0.1F) {
        accel_.xyz[2] = -force;
        step();
    }
    accel_.xyz[2] = -9.81F;
    EXPECT_FALSE(run(1.5F));
}

}  // namespace
}  // namespace stator::apps::land_detector
