// Whether the accelerometer is believed.
#include "doubt.hpp"

#include <gtest/gtest.h>

namespace stator::apps::navigation {
namespace {

constexpr float kStep = 0.001F;
constexpr float kHover = 2.13F;  // four motors' commands
constexpr float kGravity = 9.81F;

void fly(Doubt& doubt, float command, float lift, float seconds) {
    for (float t = 0.0F; t < seconds; t += kStep) doubt.update(command, {0.0F, 0.0F, -lift}, kStep);
}

Doubt after_a_hover() {
    Doubt doubt;
    fly(doubt, kHover, kGravity, 3.0F);
    return doubt;
}

TEST(Doubt, HasNoneWhereForceFollowsTheCommands) {
    Doubt doubt = after_a_hover();
    for (const float part : {1.0F, 1.5F, 0.6F, 1.8F}) {
        fly(doubt, part * kHover, part * kGravity, 1.0F);
        EXPECT_FALSE(doubt.now()) << part;
    }
}

TEST(Doubt, KnowsNothingBeforeItHasLearned) {
    Doubt doubt;
    fly(doubt, kHover, 0.0F, 0.5F);
    EXPECT_FALSE(doubt.now());
}

TEST(Doubt, BeginsSoonAfterMostOfTheForceIsMissing) {
    Doubt doubt = after_a_hover();
    fly(doubt, kHover, 0.0F, 0.03F);
    EXPECT_FALSE(doubt.now());
    fly(doubt, kHover, 0.0F, 0.1F);
    EXPECT_TRUE(doubt.now());
}

TEST(Doubt, LastsWhileTheForceStaysWrongAndThenClears) {
    Doubt doubt = after_a_hover();
    doubt.agreed();
    fly(doubt, kHover, 2.0F * kGravity, 5.0F);
    EXPECT_TRUE(doubt.now());
    fly(doubt, kHover, kGravity, 0.3F);
    EXPECT_TRUE(doubt.now());
    fly(doubt, kHover, kGravity, 0.5F);
    EXPECT_FALSE(doubt.now());
}

TEST(Doubt, ClearsByItselfWhereTheForceIsRight) {
    Doubt doubt = after_a_hover();
    doubt.agreed();
    fly(doubt, kHover, kGravity, 0.6F);
    EXPECT_FALSE(doubt.now());
}

// What it learned from a wrong sensor takes longer to unlearn.
TEST(Doubt, LastsLongerAfterAnImpossibleBias) {
    Doubt doubt = after_a_hover();
    doubt.refuted();
    doubt.agreed();
    fly(doubt, kHover, kGravity, 2.9F);
    EXPECT_TRUE(doubt.now());
    fly(doubt, kHover, kGravity, 0.2F);
    EXPECT_FALSE(doubt.now());
}

// It is the commands that say what is felt then; what is felt wrongly is not learned.
TEST(Doubt, ExpectsWhatTheCommandsExplain) {
    Doubt doubt = after_a_hover();
    doubt.agreed();
    fly(doubt, kHover, 2.0F * kGravity, 5.0F);
    EXPECT_NEAR(doubt.expected().z(), -kGravity, 0.1F);
    fly(doubt, 0.5F * kHover, 2.0F * kGravity, 1.0F);
    EXPECT_NEAR(doubt.expected().z(), -0.5F * kGravity, 0.1F);
}

// The sensor was wrong before the ratio was known.
TEST(Doubt, VerticalInnovationsCorrectWhatWasLearnedWrongly) {
    Doubt doubt;
    fly(doubt, kHover, 0.5F * kGravity, 3.0F);
    for (int fix = 0; fix < 60; ++fix) {
        doubt.agreed();
        fly(doubt, kHover, 0.5F * kGravity, 0.2F);
        // Between two fixes what it lacks makes the estimate sink.
        doubt.correct(0.2F * (-kGravity - doubt.expected().z()), 0.2F);
    }
    EXPECT_NEAR(doubt.expected().z(), -kGravity, 0.3F);
    EXPECT_TRUE(doubt.settled());
    fly(doubt, kHover, 0.5F * kGravity, 5.0F);
    EXPECT_TRUE(doubt.now());
    fly(doubt, kHover, kGravity, 1.0F);
    EXPECT_FALSE(doubt.now());
}

TEST(Doubt, IsNotSettledWhileOthersContradict) {
    Doubt doubt = after_a_hover();
    for (int fix = 0; fix < 60; ++fix) {
        doubt.agreed();
        fly(doubt, kHover, kGravity, 0.2F);
        doubt.correct(fix % 2 == 0 ? 1.5F : 1.0F, 0.2F);
    }
    EXPECT_FALSE(doubt.settled());
}

TEST(Doubt, LastsWhileTheForceSidewaysIsMoreThanWindPushes) {
    Doubt doubt = after_a_hover();
    for (float t = 0.0F; t < 5.0F; t += kStep) {
        if (t < 2.0F) doubt.agreed();
        doubt.update(kHover, {0.0F, 7.0F, -kGravity}, kStep);
    }
    EXPECT_TRUE(doubt.now());
    fly(doubt, kHover, kGravity, 1.0F);
    EXPECT_FALSE(doubt.now());
}

// What pushed from the south before the vehicle turned still does.
TEST(Doubt, ExpectsTheWindThatWasFelt) {
    Doubt doubt;
    const Quaternion north = Quaternion::Identity();
    for (float t = 0.0F; t < 60.0F; t += kStep) {
        doubt.update(kHover, {2.0F, 0.0F, -kGravity}, kStep);
        doubt.follow_wind(north, kStep);
    }
    EXPECT_NEAR(doubt.expected().x(), 2.0F, 0.05F);
    doubt.agreed();
    const Vector down(0.0F, 0.0F, 1.0F);
    doubt.follow_wind(math::from_axis_angle(down, 0.5F * math::kPi<float>), kStep);
    EXPECT_NEAR(doubt.expected().x(), 0.0F, 0.05F);
    EXPECT_NEAR(doubt.expected().y(), -2.0F, 0.05F);
}

TEST(Doubt, IsGoneAfterAReset) {
    Doubt doubt = after_a_hover();
    doubt.agreed();
    doubt.reset();
    EXPECT_FALSE(doubt.now());
}

}  // namespace
}  // namespace stator::apps::navigation
