// The position estimate against a point whose motion is known.
#include "position_estimate.hpp"

#include <gtest/gtest.h>

#include <deque>
#include <functional>
#include <limits>

#include "stator/random.hpp"
#include "stator/testing.hpp"

namespace stator::apps::position_estimate {
namespace {

using Vector = math::Vector3<double>;
using Quaternion = math::Quaternion<double>;

constexpr double kGravity = 9.80665;
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr PositionEstimateParams kParams{};  // the interface's defaults: their tuning is tested

std::array<float, 3> array(const Vector& v) {
    return {static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z())};
}

// A vehicle on a known path, its sensors, and the node. Attitude at 250 Hz, motion capture at
// 100 Hz, late by `delay_us`; each of them activates the node.
class Rig {
  public:
    using Path = std::function<Vector(double t)>;

    Path path = [](double) { return Vector::Zero(); };
    Quaternion q_NB = Quaternion::Identity();
    Vector accel_error{0, 0, 0};  // B, m/s^2
    Vector capture_error{0, 0, 0};
    double capture_noise = 0;
    double accel_noise = 0;
    uint64_t delay_us = 5000;
    uint64_t capture_period_us = 10'000;
    bool captures = true;
    bool has_attitude = true;
    uint64_t now_us = 0;

    VehicleLocalPosition newest{};
    unsigned published = 0;
    double worst_position = 0;  // over the last run
    double worst_velocity = 0;

    void run(double seconds) {
        worst_position = worst_velocity = 0;
        const uint64_t end_us = now_us + static_cast<uint64_t>(seconds * 1e6 + 0.5);
        while (now_us < end_us) {
            now_us += 1000;
            if (captures && now_us % capture_period_us == 0) look();
            if (has_attitude && now_us % 4000 == 0) activate(true, nullptr);
            if (on_the_way_.empty()) continue;
            if (on_the_way_.front().timestamp_sample + delay_us > now_us) continue;
            const VehicleOdometry seen = on_the_way_.front();
            on_the_way_.pop_front();
            activate(false, &seen);
        }
    }

    void activate(bool with_attitude, const VehicleOdometry* seen) {
        const VehicleAttitude attitude{
            .timestamp = now_us,
            .timestamp_sample = now_us,
            .q = {static_cast<float>(q_NB.w()), static_cast<float>(q_NB.x()),
                  static_cast<float>(q_NB.y()), static_cast<float>(q_NB.z())}};
        const SensorAccel accel{
            .timestamp = now_us, .timestamp_sample = now_us, .xyz = accel_now()};
        step(with_attitude ? &attitude : nullptr, accel, seen);
    }

    void step(const VehicleAttitude* attitude, const SensorAccel& accel,
              const VehicleOdometry* seen) {
        PositionEstimatePorts ports{
            .now = now_us,
            .mocap = seen != nullptr ? Input<VehicleOdometry>(*seen) : Input<VehicleOdometry>(),
            .attitude =
                attitude != nullptr ? Input<VehicleAttitude>(*attitude) : Input<VehicleAttitude>(),
            .accel = Input<SensorAccel>(accel),
            .params = Input<PositionEstimateParams>(kParams)};
        testing::Probe position(ports.position, ports.now);
        node_.step(ports);
        if (position.count() == 0) return;
        EXPECT_GT(position.newest().timestamp_sample, newest.timestamp_sample);
        newest = position.newest();
        ++published;
        EXPECT_TRUE(math::is_finite(position_error() + velocity_error()));
        worst_position = math::max(worst_position, position_error());
        worst_velocity = math::max(worst_velocity, velocity_error());
    }

    double position_error() const {
        const math::Vector3<float> position(newest.x, newest.y, newest.z);
        return math::norm(position.cast<double>() - path(time()));
    }
    double velocity_error() const {
        const math::Vector3<float> measured(newest.vx, newest.vy, newest.vz);
        return math::norm(measured.cast<double>() - velocity(time()));
    }
    bool all_valid() const {
        return newest.xy_valid && newest.z_valid && newest.v_xy_valid && newest.v_z_valid;
    }
    bool none_valid() const {
        return !newest.xy_valid && !newest.z_valid && !newest.v_xy_valid && !newest.v_z_valid;
    }

  private:
    double time() const { return static_cast<double>(now_us) * 1e-6; }
    Vector velocity(double t) const { return (path(t + 1e-4) - path(t - 1e-4)) / 2e-4; }
    std::array<float, 3> accel_now() {
        const double t = time();
        // The mean since the last prediction, as an accelerometer that averages gives it.
        const Vector acceleration = (velocity(t) - velocity(t - 4e-3)) / 4e-3;
        return array(q_NB.conjugate() * (acceleration - Vector(0, 0, kGravity)) + accel_error +
                     noise(accel_noise));
    }
    void look() {
        on_the_way_.push_back(
            {.timestamp = now_us,
             .timestamp_sample = now_us,
             .position = array(path(time()) + capture_error + noise(capture_noise)),
             .q = {1, 0, 0, 0}});
    }
    Vector noise(double sigma) {
        const double x = random_.gaussian_double();
        const double y = random_.gaussian_double();
        const double z = random_.gaussian_double();
        return Vector(x, y, z) * sigma;
    }

    PositionEstimate node_;
    math::Random random_{1};
    std::deque<VehicleOdometry> on_the_way_;
};

// 1 m to and fro at up to 1.5 m/s on all axes.
Vector shuttle(double t) {
    return Vector(math::sin(1.5 * t), math::cos(1.2 * t), -1 - 0.5 * math::sin(t));
}

TEST(PositionEstimate, SaysNothingBeforeTheFirstSampleOfEach) {
    Rig rig;
    rig.captures = false;
    rig.run(0.1);
    EXPECT_EQ(rig.published, 0U);
    rig.captures = true;
    rig.has_attitude = false;
    rig.now_us += 1'000'000;
    rig.run(0.1);
    EXPECT_EQ(rig.published, 0U);
    rig.has_attitude = true;
    rig.run(0.1);
    EXPECT_GT(rig.published, 0U);
}

TEST(PositionEstimate, KnowsThePositionFirstAndTheVelocitySoonAfter) {
    Rig rig;
    rig.path = [](double t) { return Vector(3 * t, -t, -2); };
    rig.run(0.03);
    EXPECT_TRUE(rig.newest.xy_valid && rig.newest.z_valid);
    EXPECT_FALSE(rig.newest.v_xy_valid || rig.newest.v_z_valid);
    rig.run(0.07);
    EXPECT_TRUE(rig.all_valid());
    EXPECT_LT(rig.velocity_error(), 0.01);
    EXPECT_LT(rig.position_error(), 0.001);
}

// 5 ms at 1.5 m/s are 7.5 mm.
TEST(PositionEstimate, IsNotLateThoughMotionCaptureIs) {
    Rig rig;
    rig.path = shuttle;
    rig.run(2);
    rig.run(10);
    EXPECT_LT(rig.worst_position, 0.001);
    EXPECT_LT(rig.worst_velocity, 0.01);
}

TEST(PositionEstimate, SmoothsNoise) {
    Rig rig;
    rig.path = shuttle;
    rig.capture_noise = 0.001;
    rig.accel_noise = 0.2;
    rig.run(2);
    rig.run(10);
    EXPECT_TRUE(rig.all_valid());
    EXPECT_LT(rig.worst_position, 0.004);
    EXPECT_LT(rig.worst_velocity, 0.04);  // 0.14 by differences of successive positions
}

// 0.3 m/s^2 would be 3 mm and 4 cm/s for good, if it were not learned.
TEST(PositionEstimate, LearnsTheErrorOfTheAcceleration) {
    Rig rig;
    rig.accel_error = Vector(0.3, -0.2, 0.25);
    rig.run(15);
    rig.run(1);
    EXPECT_LT(rig.worst_position, 1e-4);
    EXPECT_LT(rig.worst_velocity, 1e-3);
    rig.captures = false;
    rig.run(2);  // 0.87 m without
    EXPECT_LT(rig.position_error(), 0.01);
}

TEST(PositionEstimate, TurnsTheSpecificForceByTheAttitude) {
    Rig rig;
    rig.q_NB = math::from_euler<double>({.roll = 0.5, .pitch = -0.3, .yaw = 2.0});
    rig.path = shuttle;
    rig.run(2);
    rig.run(5);
    EXPECT_LT(rig.worst_position, 0.001);
    EXPECT_NEAR(rig.newest.heading, 2.0F, 1e-5F);
}

// Both in one activation, each in its own, or motion capture beside an attitude seen before.
TEST(PositionEstimate, WorksWithWhicheverInputActivatesIt) {
    for (const int way : {0, 1, 2}) {
        Rig rig;
        VehicleOdometry seen{
            .timestamp = 0, .timestamp_sample = 0, .position = {1, 2, -3}, .q = {}};
        for (int i = 0; i < 20; ++i) {
            rig.now_us += 10'000;
            seen.timestamp = seen.timestamp_sample = rig.now_us - 5000;
            rig.activate(true, way == 0 ? &seen : nullptr);
            if (way != 0) rig.activate(way == 2, &seen);
        }
        EXPECT_TRUE(rig.all_valid());
        EXPECT_NEAR(rig.newest.x, 1.0F, 1e-3F);
        EXPECT_NEAR(rig.newest.z, -3.0F, 1e-3F);
        EXPECT_EQ(rig.published, way == 0 ? 20U : 19U);
    }
}

TEST(PositionEstimate, FollowsRareMotionCaptureSlowly) {
    Rig rig;
    rig.path = shuttle;
    rig.capture_period_us = 250'000;
    rig.run(5);
    rig.run(20);
    EXPECT_TRUE(rig.all_valid());
    EXPECT_LT(rig.worst_position, 0.02);
}

TEST(PositionEstimate, DoesNotUseMotionCaptureThatIsTooLate) {
    Rig rig;
    rig.delay_us = 150'000;
    rig.run(1);
    EXPECT_EQ(rig.published, 0U);
}

// An accelerometer that shakes at the rate of the attitude, as rotors do near it.
TEST(PositionEstimate, TakesTheMeanOfTheSamplesBetweenAttitudes) {
    Rig rig;
    rig.run(2);
    for (int i = 1; i <= 400; ++i) {
        rig.now_us += 1000;
        const float shake = i % 4 == 0 ? 3.0F : -1.0F;
        const SensorAccel accel{.timestamp = rig.now_us,
                                .timestamp_sample = rig.now_us,
                                .xyz = {shake, 0, -static_cast<float>(kGravity)}};
        const VehicleAttitude attitude{
            .timestamp = rig.now_us, .timestamp_sample = rig.now_us, .q = {1, 0, 0, 0}};
        rig.step(i % 4 == 0 ? &attitude : nullptr, accel, nullptr);
    }
    EXPECT_LT(rig.velocity_error(), 1e-4);
}

TEST(PositionEstimate, IsNotValidHalfASecondAfterTheLastMeasurement) {
    Rig rig;
    rig.run(2);
    rig.captures = false;
    rig.run(0.48);
    EXPECT_TRUE(rig.all_valid());
    rig.run(0.05);
    EXPECT_TRUE(rig.none_valid());
    const unsigned before = rig.published;
    rig.run(1);
    EXPECT_EQ(rig.published, before + 250);  // it goes on predicting
    rig.captures = true;
    rig.run(0.1);
    EXPECT_TRUE(rig.all_valid());
}

TEST(PositionEstimate, RecoversWhereverTheVehicleIsByThen) {
    Rig rig;
    rig.path = shuttle;
    rig.run(2);
    rig.captures = false;
    rig.accel_error = Vector(1, 0, 0);
    rig.run(3);
    EXPECT_GT(rig.position_error(), 1);
    rig.captures = true;
    rig.run(0.2);
    EXPECT_TRUE(rig.all_valid());
    EXPECT_LT(rig.position_error(), 0.05);
    rig.run(5);
    rig.run(1);
    EXPECT_LT(rig.worst_position, 0.01);
}

TEST(PositionEstimate, DoesNotBelieveOutliers) {
    Rig rig;
    rig.run(2);
    rig.capture_error = Vector(0.5, 0, 0);
    rig.run(0.3);
    EXPECT_TRUE(rig.all_valid());
    EXPECT_LT(rig.worst_position, 0.001);
    rig.capture_error = Vector::Zero();
    rig.run(0.3);
    EXPECT_TRUE(rig.all_valid());
    EXPECT_LT(rig.worst_position, 0.001);
}

TEST(PositionEstimate, BelievesAPlaceThatStaysAnother) {
    Rig rig;
    rig.run(2);
    rig.capture_error = Vector(2, 0, 0);
    rig.run(1);
    EXPECT_TRUE(rig.all_valid());
    EXPECT_NEAR(rig.newest.x, 2.0F, 0.001F);
}

TEST(PositionEstimate, LeavesOutSamplesThatAreNoneOrOld) {
    Rig rig;
    rig.run(1);
    const VehicleOdometry lost{.timestamp = rig.now_us,
                               .timestamp_sample = rig.now_us,
                               .position = {kNan, 0, 0},
                               .q = {1, 0, 0, 0}};
    rig.activate(false, &lost);
    const VehicleOdometry old{.timestamp = rig.now_us,
                              .timestamp_sample = rig.now_us - 200'000,
                              .position = {0.2F, 0, 0},
                              .q = {1, 0, 0, 0}};
    rig.activate(false, &old);
    rig.now_us += 4000;
    const VehicleAttitude bad{
        .timestamp = rig.now_us, .timestamp_sample = rig.now_us, .q = {kNan, 0, 0, 0}};
    rig.step(&bad, {.timestamp = rig.now_us, .timestamp_sample = rig.now_us, .xyz = {0, 0, -9.8F}},
             nullptr);
    rig.run(1);
    EXPECT_TRUE(rig.all_valid());
    EXPECT_LT(rig.worst_position, 1e-5);
}

TEST(PositionEstimate, BeginsAnewAfterAGapInTheAttitude) {
    Rig rig;
    rig.path = shuttle;
    rig.run(2);
    rig.has_attitude = false;
    rig.run(0.4);
    rig.has_attitude = true;
    rig.run(0.004);
    EXPECT_TRUE(rig.none_valid());
    rig.run(0.1);
    EXPECT_TRUE(rig.all_valid());
    rig.run(5);
    rig.run(1);
    EXPECT_LT(rig.worst_position, 0.001);
}

}  // namespace
}  // namespace stator::apps::position_estimate
