// Airspeed: from pressure, its faults, and the wind.
#include "airspeed_selector.hpp"

#include <gtest/gtest.h>

#include "stator/random.hpp"
#include "stator/testing.hpp"

namespace stator::apps::airspeed_selector {
namespace {

using Source = AirspeedValidated::AirspeedSource;
constexpr float kRho = 1.225F;

class AirspeedSelectorTest : public ::testing::Test {
  protected:
    AirspeedSelectorTest() {
        params_ = {.scale = 1.0F,
                   .offset = 0.0F,
                   .wind_walk = 0.1F,
                   .airspeed_noise = 1.4F,
                   .sideslip_noise = 0.3F,
                   .gate = 4.0F,
                   .innovation_limit = 6.0F,
                   .innovation_integral = 12.0F,
                   .load_limit = 1.3F,
                   .stall_airspeed = 10.0F,
                   .wind_speed_from = 7.0F,
                   .wind_limit = 2.0F};
        position_.v_xy_valid = position_.v_z_valid = true;
        baro_ = {.pressure = 101325.0F, .temperature = 25.0F};
        accel_.xyz = {0.0F, 0.0F, -9.8F};
    }
    // At 17 m/s through the air.
    void fly(float seconds, float turn = 0.0F) {
        for (float t = 0.0F; t < seconds; t += 0.02F) {
            heading_ += turn * 0.02F;
            const math::SinCos<float> nose = math::sincos(heading_);
            position_.vx = 17.0F * nose.cos + wind_N_.x();
            position_.vy = 17.0F * nose.sin + wind_N_.y();
            attitude_.q =
                math::to_array(math::from_euler(math::EulerAngles<float>{0.0F, 0.0F, heading_}));
            step();
        }
    }
    void step() {
        now_us_ += 20'000;
        const float noise = static_cast<float>(random_.gaussian_double());
        const float pressure = 0.5F * kRho * 17.0F * 17.0F + noise;
        if (!is_stuck_) pressure_.differential_pressure_pa = factor_ * pressure;
        AirspeedSelectorPorts ports{
            .now = now_us_,
            .pressure = has_sensor_ ? Input(pressure_) : Input<DifferentialPressure>(),
            .baro = Input(baro_),
            .position = Input(position_),
            .attitude = Input(attitude_),
            .accel = Input(accel_),
            .land = Input(land_),
            .status = Input(status_),
            .params = Input(params_)};
        testing::Probe airspeed(ports.airspeed, now_us_);
        testing::Probe wind(ports.wind, now_us_);
        node_.step(ports);
        airspeed_ = airspeed.newest();
        wind_ = wind.newest();
    }
    // How long until it is refused, s.
    float refused_after(float most_s) {
        for (float t = 0.0F; t < most_s; t += 0.02F) {
            fly(0.02F);
            if (airspeed_.airspeed_source != Source::kSensor) return t;
        }
        return most_s;
    }

    AirspeedSelector node_;
    AirspeedSelectorParams params_{};
    DifferentialPressure pressure_{};
    SensorBaro baro_{};
    VehicleLocalPosition position_{};
    VehicleAttitude attitude_{};
    SensorAccel accel_{};
    VehicleLandDetected land_{};
    VehicleStatus status_{.arming_state = VehicleStatus::ArmingState::kArmed};
    math::Vector3<float> wind_N_ = math::Vector3<float>::Zero();
    math::Random random_{1, 1};
    AirspeedValidated airspeed_{};
    AirspeedWind wind_{};
    float heading_ = 0.0F;
    float factor_ = 1.0F;
    bool has_sensor_ = true;
    bool is_stuck_ = false;
    uint64_t now_us_ = 0;
};

TEST_F(AirspeedSelectorTest, TheDensityMakesTheTrueAirspeed) {
    fly(1.0F);
    EXPECT_NEAR(airspeed_.calibrated_airspeed_m_s, 17.0F, 0.3F);
    EXPECT_NEAR(airspeed_.true_airspeed_m_s, 17.0F, 0.3F);
    // 1000 m of the standard atmosphere: 89875 Pa, 8.5 degC, density 1.112: 5 % faster.
    baro_ = {.pressure = 89875.0F, .temperature = 18.5F};
    step();
    EXPECT_NEAR(airspeed_.true_airspeed_m_s / airspeed_.calibrated_airspeed_m_s, 1.0496F, 1e-3F);
}

TEST_F(AirspeedSelectorTest, ATurnShowsTheWind) {
    wind_N_ = {5.0F, -3.0F, 0.0F};
    fly(2.0F);
    fly(40.0F, 0.2F);  // 1.3 turns
    EXPECT_TRUE(wind_.valid);
    EXPECT_NEAR(wind_.windspeed_north, 5.0F, 0.5F);
    EXPECT_NEAR(wind_.windspeed_east, -3.0F, 0.5F);
    EXPECT_EQ(airspeed_.airspeed_source, Source::kSensor);
}

TEST_F(AirspeedSelectorTest, ABlockedPitotIsRefusedAndTheWindTakesItsPlace) {
    wind_N_ = {5.0F, -3.0F, 0.0F};
    fly(40.0F, 0.2F);
    factor_ = 0.0F;
    EXPECT_LT(refused_after(5.0F), 1.0F);
    EXPECT_EQ(airspeed_.airspeed_source, Source::kGroundMinusWind);
    EXPECT_NEAR(airspeed_.true_airspeed_m_s, 17.0F, 0.7F);
    fly(60.0F, 0.2F);
    EXPECT_NEAR(airspeed_.true_airspeed_m_s, 17.0F, 1.0F);
    factor_ = 1.0F;  // it is not believed again in this flight
    fly(5.0F);
    EXPECT_EQ(airspeed_.airspeed_source, Source::kGroundMinusWind);
}

// Publicly reported: the absolute value of the pressure hides tubes that are swapped.
TEST_F(AirspeedSelectorTest, SwappedTubesAreRefused) {
    fly(10.0F, 0.2F);
    factor_ = -1.0F;
    EXPECT_LT(refused_after(5.0F), 1.1F);
    EXPECT_NE(airspeed_.faults & AirspeedCheck::kTooLow, 0);
}

TEST_F(AirspeedSelectorTest, ASensorThatRepeatsItselfOrIsSilentIsRefused) {
    fly(10.0F, 0.2F);
    is_stuck_ = true;
    EXPECT_NEAR(refused_after(5.0F), 2.0F, 0.1F);
    EXPECT_EQ(airspeed_.faults, AirspeedCheck::kStuck);
}

TEST_F(AirspeedSelectorTest, WithoutASensorNothingIsUsed) {
    fly(10.0F, 0.2F);
    has_sensor_ = false;
    fly(0.02F);
    EXPECT_NE(airspeed_.airspeed_source, Source::kSensor);
    fly(1.0F);
    EXPECT_NE(airspeed_.faults & AirspeedCheck::kMissing, 0);
}

TEST_F(AirspeedSelectorTest, OnTheGroundNothingIsRefused) {
    land_.landed = true;
    factor_ = 0.0F;
    fly(20.0F);
    EXPECT_EQ(airspeed_.faults, 0);
    EXPECT_EQ(airspeed_.airspeed_source, Source::kSensor);
}

// Gusts that change the airspeed by 3 m/s for some seconds, for half an hour; on a straight way,
// too, where nothing tells a sensor's scale from the wind.
TEST_F(AirspeedSelectorTest, GustsAreNoFault) {
    wind_N_ = {6.0F, 0.0F, 0.0F};
    for (int i = 0; i < 180; ++i) {
        const float gust = 1.0F + 0.18F * static_cast<float>(i % 3 - 1);
        factor_ = gust * gust;
        fly(10.0F, i < 90 ? 0.2F : 0.0F);
        ASSERT_EQ(airspeed_.faults, 0) << i;
        ASSERT_NEAR(wind_.windspeed_north, 6.0F, 4.0F) << i;
    }
}

}  // namespace
}  // namespace stator::apps::airspeed_selector
