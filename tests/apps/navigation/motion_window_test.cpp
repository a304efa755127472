// Motions compose without coning errors, and the window takes them apart again.
#include "motion_window.hpp"

#include <gtest/gtest.h>

#include <deque>

#include "stator/random.hpp"

namespace stator::apps::navigation {
namespace {

void expect_near(const Motion& found, const Motion& expected, float tolerance) {
    const Quaternion turned = found.turn.conjugate() * expected.turn;
    EXPECT_LT(math::norm(turned.vec()), tolerance);
    EXPECT_LT(math::norm(found.velocity - expected.velocity), tolerance * 10.0F);
    EXPECT_LT(math::norm(found.position - expected.position), tolerance * 10.0F);
    EXPECT_NEAR(found.time, expected.time, tolerance);
}

Vector random_vector(math::Random& random, float scale) {
    const float x = random.gaussian_float();
    const float y = random.gaussian_float();
    const float z = random.gaussian_float();
    return Vector(x, y, z) * scale;
}

Motion random_motion(math::Random& random) {
    const Vector rate = random_vector(random, 2.0F);
    return constant_motion(rate, random_vector(random, 10.0F), 0.004F);
}

// A body that cones: its axis moves round, no axis of the gyro sees a mean rate but z, where it is
// (1 - cos a) w (P. Savage, "Strapdown inertial navigation integration algorithm design", JGCD
// 1998). At 1 kHz and 20 Hz of coning, the sum of the samples would be wrong by that rate.
TEST(Motion, ComposesWithoutConingError) {
    constexpr float kAngle = 0.05F;
    constexpr float kFrequency = 2.0F * math::kPi<float> * 20.0F;
    constexpr float kPeriod = 0.001F;
    const auto attitude = [](float t) {
        const math::SinCos<float> at = math::sincos(kFrequency * t);
        return math::from_axis_angle(Vector(at.cos, at.sin, 0.0F), kAngle);
    };
    Motion sum;
    Vector plain = Vector::Zero();
    for (int i = 0; i < 1000; ++i) {
        const float t = static_cast<float>(i) * kPeriod;
        const Quaternion turn = attitude(t).conjugate() * attitude(t + kPeriod);
        const Vector angle = math::to_rotation_vector(turn);
        plain += angle;
        sum = sum * constant_motion(angle / kPeriod, Vector::Zero(), kPeriod);
    }
    const float coned = math::abs(plain.z());
    EXPECT_GT(coned, 0.1F);
    EXPECT_LT(math::norm(math::to_rotation_vector(sum.turn)), 2e-4F);
}

// Sculling: the body swings about x as its force along y swings in step; the mean of the product
// is felt along z.
TEST(Motion, FeelsSculling) {
    constexpr int kSamples = 1000;
    constexpr float kSwing = 0.05F;  // rad
    constexpr float kForce = 5.0F;   // m/s^2
    const auto phase = [](float i) { return 2.0F * math::kPi<float> * i / 50.0F; };
    Motion sum;
    for (int i = 0; i < kSamples; ++i) {
        const float at = static_cast<float>(i);
        const float turned = kSwing * (math::sin(phase(at + 1.0F)) - math::sin(phase(at)));
        const Vector force(0.0F, kForce * math::sin(phase(at + 0.5F)), 0.0F);
        sum = sum * constant_motion(Vector(turned * 1000.0F, 0.0F, 0.0F), force, 0.001F);
    }
    // The mean of kSwing sin kForce sin, over one second.
    EXPECT_NEAR(sum.velocity.z(), kSwing * kForce / 2.0F, 2e-3F);
}

TEST(Motion, BetweenUndoesTheProduct) {
    math::Random random(1);
    Motion a;
    Motion b;
    for (int i = 0; i < 100; ++i) a = a * random_motion(random);
    for (int i = 0; i < 100; ++i) b = b * random_motion(random);
    expect_near(between(a, a * b), b, 1e-5F);
}

// Against the plain product of the same steps, with the window run round many times.
TEST(MotionWindow, KnowsTheWayFromTheHorizonToNow) {
    math::Random random(2);
    MotionWindow window;
    window.restart(0, {});
    std::deque<Motion> steps;
    for (uint64_t i = 1; i <= 2000; ++i) {
        Motion step;
        for (int sample = 0; sample < 2; ++sample) {
            const Vector rate = random_vector(random, 2.0F);
            const Vector force = random_vector(random, 10.0F);
            window.add(rate, force, 0.004F);
            step = step * constant_motion(rate, force, 0.004F);
        }
        EXPECT_NEAR(window.open_time(), 0.008F, 1e-6F);
        steps.push_back(step);
        window.close(i * 8000, {});
        if (steps.size() <= 40 + i % 20) continue;
        EXPECT_EQ(window.step_end_us(), (i + 1 - steps.size()) * 8000);
        expect_near(window.take().motion, steps.front(), 1e-5F);
        steps.pop_front();
        Motion ahead;
        for (const Motion& later : steps) ahead = ahead * later;
        expect_near(window.ahead(), ahead, 2e-5F);
    }
}

// A new bias is taken off at some point: each step says which it was.
TEST(MotionWindow, SaysWhichBiasWasTakenOff) {
    MotionWindow window;
    window.restart(0, {});
    const Vector force(1.0F, 2.0F, 3.0F);
    for (uint64_t i = 1; i <= 500; ++i) {
        ImuBias bias;
        bias.accel.x() = static_cast<float>(i) * 0.001F;
        window.add(Vector::Zero(), force, 0.008F);
        window.close(i * 8000, bias);
        if (i < 30) continue;
        const MotionWindow::Step step = window.take();
        const Vector felt = step.motion.velocity / step.motion.time + step.bias.accel;
        EXPECT_LT(math::norm(felt - force), 1e-4F);
        EXPECT_GE(step.bias.accel.x(), static_cast<float>(i) * 0.001F - 0.1F);
    }
}

TEST(MotionWindow, IsFullBeforeItOverwritesAStep) {
    MotionWindow window;
    window.restart(0, {});
    uint64_t end_us = 0;
    while (!window.full()) {
        window.add(Vector::Zero(), Vector::Zero(), 0.008F);
        window.close(end_us += 8000, {});
    }
    EXPECT_EQ(end_us, 8000 * (MotionWindow::kCapacity - 1));
    EXPECT_EQ(window.step_end_us(), 8000U);
}

}  // namespace
}  // namespace stator::apps::navigation
