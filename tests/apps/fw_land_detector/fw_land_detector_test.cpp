// When an aeroplane flies, has landed, or lies on its side.
#include "fw_land_detector.hpp"

#include <gtest/gtest.h>

#include "stator/rotation.hpp"
#include "stator/testing.hpp"

namespace stator::apps::fw_land_detector {
namespace {

class FwLandDetectorTest : public ::testing::Test {
  protected:
    FwLandDetectorTest() {
        params_ = {.still = 1.5F,
                   .sinking = 0.3F,
                   .pulls = 0.1F,
                   .landed_after = 1.5F,
                   .takeoff_height = 1.0F,
                   .takeoff_airspeed = 10.0F,
                   .blind_after = 4.0F,
                   .crashed_after = 1.5F};
        position_ = {.xy_valid = true, .z_valid = true, .v_xy_valid = true, .v_z_valid = true};
        lean(0.0F);
        step();
        status_.arming_state = VehicleStatus::ArmingState::kArmed;
        step();
    }
    void lean(float roll) {
        attitude_.q = math::to_array(math::from_euler(math::EulerAngles<float>{roll, 0.0F, 0.0F}));
    }
    void step(int count = 1) {
        for (int i = 0; i < count; ++i) {
            now_us_ += 20'000;
            FwLandDetectorPorts ports{.now = now_us_,
                                      .position = Input(position_),
                                      .thrust = Input(thrust_),
                                      .status = Input(status_),
                                      .accel = Input(accel_),
                                      .gyro = Input(gyro_),
                                      .attitude = Input(attitude_),
                                      .airspeed = Input(airspeed_),
                                      .params = Input(params_)};
            testing::Probe land(ports.land, now_us_);
            node_.step(ports);
            land_ = land.newest();
        }
    }
    void take_off() {
        thrust_.xyz[0] = 1.0F;
        airspeed_.calibrated_airspeed_m_s = 14.0F;
        position_.vx = 14.0F;
        position_.vz = -1.0F;
        position_.z = -5.0F;
        step();
    }

    FwLandDetector node_;
    FwLandDetectorParams params_{};
    VehicleLocalPosition position_{};
    VehicleThrustSetpoint thrust_{};
    VehicleStatus status_{.arming_state = VehicleStatus::ArmingState::kDisarmed};
    SensorAccel accel_{.xyz = {0.0F, 0.0F, -9.8F}};
    SensorGyro gyro_{};
    VehicleAttitude attitude_{};
    AirspeedValidated airspeed_{};
    VehicleLandDetected land_{};
    uint64_t now_us_ = 0;
};

TEST_F(FwLandDetectorTest, RollsBeforeItFlies) {
    EXPECT_TRUE(land_.landed);
    thrust_.xyz[0] = 1.0F;
    position_.vx = 9.0F;
    airspeed_.calibrated_airspeed_m_s = 9.0F;
    step(50);
    EXPECT_TRUE(land_.landed);
    take_off();
    EXPECT_FALSE(land_.landed);
}

TEST_F(FwLandDetectorTest, HasLandedWhenItRestsWithoutThrust) {
    take_off();
    thrust_.xyz[0] = 0.0F;
    position_.vz = 0.0F;
    position_.vx = 8.0F;
    step(200);
    EXPECT_FALSE(land_.landed);
    position_.vx = 0.5F;
    step(70);
    EXPECT_FALSE(land_.landed);
    step(10);
    EXPECT_TRUE(land_.landed);
}

// In a wind as strong as the airspeed an aeroplane stands over one place.
TEST_F(FwLandDetectorTest, WithThrustItFliesThoughItDoesNotMove) {
    take_off();
    position_.vx = position_.vz = 0.0F;
    thrust_.xyz[0] = 0.5F;
    step(500);
    EXPECT_FALSE(land_.landed);
}

TEST_F(FwLandDetectorTest, WithoutASpeedItsWeightCounts) {
    take_off();
    thrust_.xyz[0] = 0.0F;
    airspeed_.calibrated_airspeed_m_s = 13.0F;
    position_.v_xy_valid = position_.v_z_valid = false;
    step(300);
    EXPECT_FALSE(land_.landed);
    airspeed_.calibrated_airspeed_m_s = 1.0F;
    step(220);
    EXPECT_TRUE(land_.landed);
}

TEST_F(FwLandDetectorTest, LyingOnItsSideItHasCrashed) {
    take_off();
    lean(1.5F);
    step(100);
    EXPECT_FALSE(land_.crashed);  // it still moves
    position_.vx = position_.vz = 0.0F;
    step(100);
    EXPECT_TRUE(land_.crashed);
}

}  // namespace
}  // namespace stator::apps::fw_land_detector
