// The approach: its geometry, and the order of its phases.
#include "landing.hpp"

#include <gtest/gtest.h>

namespace stator::apps::fw_guidance {
namespace {

using Phase = Landing::Phase;
constexpr float kSlope = 0.0873F;  // 5 deg: 20 m of height are 228.5 m
// 14 m/s down that slope is 1.225 m/s. From there to 0.4 m/s within 3 m takes
// 3 / 0.825 ln(1.225 / 0.4) = 4.07 s or 57.0 m; the slope alone reaches 34.3 m.
constexpr float kFurther = 22.7F;

LandingPlan plan() {
    return {.place = {100.0F, 50.0F},
            .heading = 0.0F,
            .slope = kSlope,
            .height = 20.0F,
            .radius = 80.0F,
            .flare_height = 3.0F,
            .flare_sink = 0.4F,
            .ground_speed = 14.0F};
}

class LandingTest : public ::testing::Test {
  protected:
    LandingTest() { landing_.begin(plan()); }
    Phase at(float north, float east, float height, Vector2 velocity, float climb = 0.0F) {
        landing_.update(
            {.position = {north, east}, .velocity = velocity, .height = height, .climb = climb},
            0.02F);
        return landing_.phase();
    }
    void come_to_slope() {
        ASSERT_EQ(at(-128.5F - kFurther, 50.0F, 20.0F, {14.0F, 0.0F}), Phase::kSlope);
    }

    Landing landing_;
};

TEST_F(LandingTest, TheCircleTouchesTheApproach) {
    const Path circle = landing_.path();
    ASSERT_TRUE(circle.is_circle());
    EXPECT_NEAR(circle.end().x(), 100.0F - 228.5F - kFurther, 0.5F);
    EXPECT_NEAR(circle.end().y(), 130.0F, 0.01F);
    const PathPoint off = circle.nearest({-128.5F - kFurther, 49.0F});
    EXPECT_NEAR(off.tangent.x(), 1.0F, 1e-2F);
}

TEST_F(LandingTest, LeavesTheCircleAtItsHeightOnTheWayToThePlace) {
    const float start = -128.5F - kFurther;
    EXPECT_EQ(at(start, 50.0F, 30.0F, {14.0F, 0.0F}), Phase::kCircle);    // too high
    EXPECT_EQ(at(start, 210.0F, 20.0F, {-14.0F, 0.0F}), Phase::kCircle);  // the other side
    EXPECT_EQ(at(start, 50.0F, 20.0F, {0.0F, 14.0F}), Phase::kCircle);    // another course
    come_to_slope();
    EXPECT_NEAR(landing_.height_at({0.0F, 50.0F}), (100.0F - kFurther) * 0.0875F, 0.05F);
}

TEST_F(LandingTest, FlaresLowAndRollsOnceTheGroundHoldsIt) {
    come_to_slope();
    EXPECT_EQ(at(43.0F, 50.0F, 2.9F, {14.0F, 0.0F}, -1.2F), Phase::kFlare);
    EXPECT_NEAR(landing_.sink_at(3.0F), 1.225F, 1e-2F);
    EXPECT_NEAR(landing_.sink_at(0.0F), 0.4F, 1e-5F);
    for (int i = 0; i < 50; ++i)
        ASSERT_EQ(at(80.0F, 50.0F, 1.0F, {14.0F, 0.0F}, -0.4F), Phase::kFlare);
    for (int i = 0; i < 16; ++i) at(90.0F, 50.0F, 0.5F, {13.0F, 0.0F}, 0.0F);
    EXPECT_EQ(landing_.phase(), Phase::kRoll);
}

// A gust stops the sink for a moment.
TEST_F(LandingTest, HighUpTheGroundMustHoldItForLonger) {
    come_to_slope();
    at(43.0F, 50.0F, 2.9F, {14.0F, 0.0F}, -1.2F);
    for (int i = 0; i < 50; ++i) at(60.0F, 50.0F, 2.0F, {14.0F, 0.0F}, 0.1F);
    EXPECT_EQ(landing_.phase(), Phase::kFlare);
    for (int i = 0; i < 30; ++i) at(70.0F, 50.0F, 2.0F, {14.0F, 0.0F}, 0.0F);
    EXPECT_EQ(landing_.phase(), Phase::kRoll);
}

// Publicly reported: aeroplanes flared over the place to land at, far too high.
TEST_F(LandingTest, GoesAroundInsteadOfAFlareHighUp) {
    come_to_slope();
    EXPECT_EQ(at(105.0F, 50.0F, 12.0F, {14.0F, 0.0F}, -1.0F), Phase::kCircle);
    EXPECT_EQ(landing_.go_arounds(), 1U);
}

TEST_F(LandingTest, WithoutPowerItLandsWhereTheCircleEnds) {
    EXPECT_EQ(at(-300.0F, 200.0F, 10.0F, {12.0F, 0.0F}, -1.5F), Phase::kCircle);
    EXPECT_EQ(at(-300.0F, 230.0F, 2.9F, {12.0F, 0.0F}, -1.5F), Phase::kFlare);
}

TEST_F(LandingTest, GoesAroundBesideTheApproach) {
    come_to_slope();
    EXPECT_EQ(at(50.0F, 65.0F, 5.0F, {14.0F, 0.0F}, -1.0F), Phase::kCircle);
}

}  // namespace
}  // namespace stator::apps::fw_guidance
