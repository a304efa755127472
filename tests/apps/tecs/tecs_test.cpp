// Total energy control on an aeroplane of two states, height and airspeed, whose energy follows the
// throttle and whose path follows the pitch at once. What it must reach is what PX4's own unit test
// of TECS demands of such a plant, at its trim of 16 m/s and 50 Hz.
#include "tecs.hpp"

#include <gtest/gtest.h>

#include "stator/testing.hpp"

namespace stator::apps::tecs {
namespace {

constexpr float kNaN = math::canonical_nan<float>();
constexpr float kGravity = 9.80665F;
constexpr float kTrim = 16.0F;
constexpr float kAlpha = 0.06F;  // rad
constexpr float kDt = 0.02F;

TecsParams params_of_interface() {
    return {.throttle_trim = 0.55F,
            .throttle_min = 0.0F,
            .throttle_max = 1.0F,
            .climb_max = 4.5F,
            .sink_min = 2.2F,
            .climb_target = 3.0F,
            .sink_target = 1.8F,
            .trim_airspeed = kTrim,
            .min_airspeed = 12.0F,
            .max_airspeed = 22.0F,
            .stall_airspeed = 10.0F,
            .height_time = 3.0F,
            .airspeed_time = 4.0F,
            .height_ff = 0.8F,
            .throttle_damping = 0.5F,
            .throttle_integral = 0.3F,
            .pitch_damping = 0.7F,
            .pitch_integral = 0.3F,
            .speed_weight = 1.0F,
            .roll_to_throttle = 15.0F,
            .energy_rate_time = 0.4F,
            .vertical_acceleration = 7.0F,
            .roll_limit = 0.8F,
            .roll_slew = 1.57F,
            .pitch_min = -0.35F,
            .pitch_max = 0.4F};
}

class Aeroplane {
  public:
    Aeroplane() {
        for (int i = 0; i < 10; ++i) step(100.0F, kTrim);
    }
    void step(float wanted_height, float airspeed) {
        const float climb = speed * math::sin(pitch_ - kAlpha);
        const Wanted wanted{.height = wanted_height,
                            .height_rate = kNaN,
                            .airspeed = airspeed,
                            .pitch = kNaN,
                            .throttle = kNaN};
        const Motion motion{.height = height,
                            .height_rate = climb,
                            .airspeed = knows_speed ? speed : kNaN,
                            .airspeed_rate = gain_,
                            .load_factor = load_factor,
                            .tas_over_eas = 1.0F,
                            .pitch = pitch_};
        control.update(motion, wanted, params, kDt);
        const float beyond = control.throttle() - params.throttle_trim;
        const float climbs =
            beyond > 0.0F ? beyond / 0.45F * params.climb_max : beyond / 0.55F * params.sink_min;
        const float energy = kGravity * (has_power ? climbs : -params.sink_min);
        gain_ = (energy - kGravity * climb) / speed;
        speed += gain_ * kDt;
        height += climb * kDt;
        pitch_ = control.pitch();
        highest = math::max(highest, height);
        worst_speed = math::max(worst_speed, math::abs(speed - kTrim));
    }
    void fly(float seconds, float wanted_height, float airspeed = kTrim) {
        for (float t = 0.0F; t < seconds; t += kDt) step(wanted_height, airspeed);
    }

    EnergyControl control;
    TecsParams params = params_of_interface();
    float height = 100.0F;
    float speed = kTrim;
    float load_factor = 1.0F;
    float highest = 0.0F;
    float worst_speed = 0.0F;
    bool knows_speed = true;
    bool has_power = true;

  private:
    float pitch_ = kAlpha;
    float gain_ = 0.0F;
};

TEST(Tecs, CruisesWithoutError) {
    Aeroplane plane;
    plane.fly(60.0F, 100.0F);
    EXPECT_NEAR(plane.height, 100.0F, 1e-3F);
    EXPECT_NEAR(plane.speed, kTrim, 1e-3F);
    EXPECT_NEAR(plane.control.throttle(), 0.55F, 1e-3F);
}

TEST(Tecs, ClimbsAndSinksAtConstantAirspeed) {
    for (const float step : {50.0F, -50.0F}) {
        Aeroplane plane;
        plane.fly(60.0F, 100.0F + step);
        EXPECT_LT(plane.worst_speed, 0.5F) << step;
        EXPECT_NEAR(plane.height, 100.0F + step, 0.5F) << step;
        EXPECT_LT(plane.highest, 102.0F + math::max(step, 0.0F)) << step;
    }
}

TEST(Tecs, RegainsLostAirspeed) {
    Aeroplane plane;
    plane.speed -= 4.0F;
    plane.fly(3.0F, 100.0F);
    EXPECT_GT(plane.speed, kTrim - 2.5F);
    plane.fly(17.0F, 100.0F);
    EXPECT_NEAR(plane.speed, kTrim, 0.3F);
}

// Without power, so that only height can make speed. At 40 deg of bank the least airspeed is 12 /
// sqrt(cos 40) = 13.7 m/s.
TEST(Tecs, InATurnBelowItsLeastAirspeedItGivesUpHeight) {
    Aeroplane plane;
    plane.load_factor = 1.0F / math::cos(0.698F);
    plane.speed = 11.9F;
    plane.has_power = false;
    plane.fly(0.2F, 110.0F);
    EXPECT_GT(plane.control.status().underspeed_ratio, 0.5F);
    EXPECT_GT(plane.control.throttle(), 0.9F);
    plane.fly(8.0F, 110.0F);
    EXPECT_GT(plane.speed, 12.0F);  // 1.05 of the stall at that bank
    EXPECT_LT(plane.height, 95.0F);
}

// Publicly reported: a clogged pitot reads low and a height hold dives without an end. Without an
// airspeed, height wins.
TEST(Tecs, WithoutAnAirspeedItHoldsTheHeight) {
    Aeroplane plane;
    plane.knows_speed = false;
    plane.fly(60.0F, 120.0F);
    EXPECT_NEAR(plane.height, 120.0F, 1.0F);
    EXPECT_EQ(plane.control.status().speed_weight, 0.0F);
    EXPECT_GT(plane.speed, 14.0F);
}

// Publicly reported: integrals of zero at the hand-over cost metres of height.
TEST(Tecs, BeginsWithThePitchThatThereIs) {
    Aeroplane plane;
    EXPECT_NEAR(plane.control.pitch(), kAlpha, 1e-3F);
    EXPECT_NEAR(plane.control.status().pitch_integ, kAlpha, 1e-3F);
}

TEST(Tecs, WithoutAHeightPitchHoldsTheAirspeed) {
    Aeroplane plane;
    plane.has_power = false;
    for (int i = 0; i < 2000; ++i) plane.step(kNaN, 14.0F);
    EXPECT_NEAR(plane.speed, 14.0F, 0.7F);
    EXPECT_LT(plane.height, 80.0F);
}

}  // namespace
}  // namespace stator::apps::tecs
