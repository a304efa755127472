// The attitude node against vehicles whose attitude is known.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "rig.hpp"

namespace stator::testing {

using Vector = AttitudeRig::Vector;
using Quaternion = AttitudeRig::Quaternion;

namespace {

constexpr double kGravity = 9.80665;
constexpr double kDegree = math::kPi<double> / 180;

std::array<float, 3> array(const Vector& v) {
    return {static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z())};
}

}  // namespace

AttitudeRig::Vector AttitudeRig::noise(double sigma) {
    if (sigma == 0) return Vector::Zero();
    const double x = random_.gaussian_double();
    const double y = random_.gaussian_double();
    const double z = random_.gaussian_double();
    return Vector(x, y, z) * sigma;
}

// Motion capture gives the heading as a level attitude.
VehicleOdometry AttitudeRig::seen_now() const {
    const math::SinCos<double> half = math::sincos(math::heading(q_NB) / 2);
    return {.timestamp = now_us,
            .timestamp_sample = now_us,
            .position = {},
            .q = {static_cast<float>(half.cos), 0.0F, 0.0F, static_cast<float>(half.sin)}};
}

bool AttitudeRig::step(const SensorGyro& gyro, const SensorAccel& accel, const SensorMag* mag,
                       const VehicleOdometry* seen) {
    VehicleStatus status{};
    status.arming_state =
        armed ? VehicleStatus::ArmingState::kArmed : VehicleStatus::ArmingState::kDisarmed;
    apps::attitude::AttitudePorts ports{
        .now = now_us,
        .gyro = Input<SensorGyro>(gyro),
        .accel = Input<SensorAccel>(accel),
        .mag = mag != nullptr ? Input<SensorMag>(*mag) : Input<SensorMag>(),
        .heading = seen != nullptr ? Input<VehicleOdometry>(*seen) : Input<VehicleOdometry>(),
        .status = has_status ? Input<VehicleStatus>(status) : Input<VehicleStatus>(),
        .params = Input<AttitudeParams>(params)};
    Probe attitude(ports.attitude, ports.now);
    node_.step(ports);
    if (attitude.count() == 0) return false;
    EXPECT_EQ(attitude.newest().timestamp_sample, gyro.timestamp_sample);
    const auto& q = attitude.newest().q;
    estimate = math::Quaternion<float>(q[0], q[1], q[2], q[3]).cast<double>();
    ++published;
    return true;
}

void AttitudeRig::run(double seconds, const Motion& rate_B, const Motion& acceleration_N) {
    const double dt = static_cast<double>(period_us) * 1e-6;
    const auto steps = static_cast<unsigned>(seconds / dt + 0.5);
    double sum = 0;
    for (unsigned i = 0; i < steps; ++i) {
        now_us += period_us;
        const Vector rate = rate_B(i * dt);
        q_NB = math::integrate(q_NB, rate, dt);
        const Vector force_N = acceleration_N(i * dt) - Vector(0, 0, kGravity);
        const Vector gyro = rate + gyro_bias + noise(gyro_noise);
        const Vector accel = q_NB.conjugate() * force_N + noise(accel_noise);
        const Vector field = q_NB.conjugate() * field_N + disturbance_B;
        const SensorMag mag{.timestamp = now_us, .timestamp_sample = now_us, .xyz = array(field)};
        const bool mag_due = mag_period_us != 0 && now_us % mag_period_us == 0;
        if (capture_period_us != 0 && now_us % capture_period_us == 0) {
            on_the_way_.push_back(seen_now());
        }
        VehicleOdometry seen{};
        const bool arrived = !on_the_way_.empty() &&
                             on_the_way_.front().timestamp_sample + capture_delay_us <= now_us;
        if (arrived) {
            seen = on_the_way_.front();
            on_the_way_.erase(on_the_way_.begin());
        }
        step({.timestamp = now_us, .timestamp_sample = now_us, .xyz = array(gyro)},
             {.timestamp = now_us, .timestamp_sample = now_us, .xyz = array(accel)},
             mag_due ? &mag : nullptr, arrived ? &seen : nullptr);
        sum += math::square(tilt_error());
    }
    tilt_rms_ = math::sqrt(sum / steps);
}

double AttitudeRig::tilt_error() const {
    const Vector down(0, 0, 1);
    const Vector seen = estimate.conjugate() * down;
    const Vector real = q_NB.conjugate() * down;
    return math::atan2(math::norm(seen.cross(real)), seen.dot(real));
}

double AttitudeRig::heading_error() const {
    return math::wrap_pi(math::heading(q_NB) - math::heading(estimate));
}

}  // namespace stator::testing

namespace stator::apps::attitude {
namespace {

using testing::AttitudeRig;
using testing::kDegree;
using testing::Vector;

const AttitudeRig::Motion kNone = AttitudeRig::kNone;

AttitudeRig::Quaternion attitude(double roll_deg, double pitch_deg, double yaw_deg) {
    return math::from_euler<double>(
        {.roll = roll_deg * kDegree, .pitch = pitch_deg * kDegree, .yaw = yaw_deg * kDegree});
}

TEST(Attitude, SaysNothingBeforeTheFirstAccelerometerSample) {
    AttitudeRig rig;
    const SensorGyro gyro{.timestamp = 1000, .timestamp_sample = 1000, .xyz = {}};
    const float nan = std::numeric_limits<float>::quiet_NaN();
    EXPECT_FALSE(rig.step(gyro, {.timestamp = 1000, .timestamp_sample = 1000, .xyz = {nan, 0, 0}}));
}

TEST(Attitude, KnowsTheInclinationFromTheFirstSample) {
    for (const auto& q : {attitude(0, 0, 0), attitude(30, -20, 0), attitude(180, 0, 0),
                          attitude(-170, 5, 0), attitude(0, 90, 0)}) {
        AttitudeRig rig;
        rig.q_NB = q;
        rig.run(0.001, kNone, kNone);
        EXPECT_EQ(rig.published, 1U);
        EXPECT_LT(rig.tilt_error(), 1e-3 * kDegree);
    }
}

TEST(Attitude, KnowsTheHeadingFromTheFirstSample) {
    for (const double yaw : {0.0, 90.0, 179.0, -135.0}) {
        AttitudeRig rig;
        rig.mag_period_us = 1000;
        rig.q_NB = attitude(20, -10, yaw);
        rig.run(0.001, kNone, kNone);
        EXPECT_NEAR(rig.heading_error(), 0, 1e-3 * kDegree) << yaw;
    }
}

TEST(Attitude, CountsDeclinationFromTrueNorthOverEast) {
    AttitudeRig rig;
    rig.mag_period_us = 1000;
    rig.params.magnetic_declination = static_cast<float>(10 * kDegree);
    rig.run(0.001, kNone, kNone);  // the nose points to magnetic north
    EXPECT_NEAR(math::heading(rig.estimate), 10 * kDegree, 1e-3 * kDegree);
}

TEST(Attitude, FollowsTheGyroAtOnce) {
    AttitudeRig rig;
    rig.run(0.001, kNone, kNone);
    rig.run(0.5, AttitudeRig::constant({0, 0, math::kPi<double>}), kNone);
    EXPECT_NEAR(math::heading(rig.estimate), 90 * kDegree, 0.01 * kDegree);
    EXPECT_LT(rig.tilt_error(), 0.01 * kDegree);
}

// 30 deg/s about all axes, with the same parameters at the rates of a flight and of a recording.
TEST(Attitude, NeedsNoOtherParametersAtAnotherRate) {
    for (const uint64_t period_us : {1000U, 3500U, 5000U}) {
        AttitudeRig rig;
        rig.period_us = period_us;
        rig.gyro_bias = Vector(0.01, -0.01, 0.005);
        rig.rest(3);
        rig.run(30, AttitudeRig::constant({0.5, 0.3, -0.4}), kNone);
        EXPECT_LT(rig.tilt_error(), 0.25 * kDegree) << period_us;
    }
}

TEST(Attitude, LearnsTheGyroBiasAtRest) {
    AttitudeRig rig;
    rig.gyro_bias = Vector(0.02, -0.02, 0.02);
    rig.gyro_noise = 0.002;
    rig.accel_noise = 0.05;
    rig.rest(4);
    const double heading = math::heading(rig.estimate);
    EXPECT_LT(rig.tilt_error(), 0.1 * kDegree);
    rig.rest(20);
    EXPECT_NEAR(math::heading(rig.estimate), heading, 0.1 * kDegree);  // 22.9 deg without
    EXPECT_LT(rig.tilt_rms(), 0.1 * kDegree);
}

// The inclination shows what of the bias is not vertical; turning about all axes shows all of it.
TEST(Attitude, LearnsTheGyroBiasInMotion) {
    AttitudeRig rig;
    rig.gyro_bias = Vector(0.01, -0.01, 0.01);
    const auto tumbling = [](double t) {
        return Vector(math::sin(0.7 * t), math::sin(0.9 * t + 1), math::sin(0.5 * t + 2));
    };
    rig.run(60, tumbling, kNone);
    const double before = rig.heading_error();
    rig.run(60, tumbling, kNone);
    // 0.1 deg/s over the accelerometer's 3 s; the bias itself is ten times that.
    EXPECT_LT(rig.tilt_rms(), 0.3 * kDegree);
    EXPECT_NEAR(rig.heading_error(), before, 2 * kDegree);
}

TEST(Attitude, LearnsTheVerticalGyroBiasFromMotionCapture) {
    AttitudeRig rig;
    rig.has_status = rig.armed = true;
    rig.gyro_bias = Vector(0, 0, 0.02);
    rig.capture_period_us = 10'000;
    rig.rest(20);
    EXPECT_NEAR(rig.heading_error(), 0, 0.05 * kDegree);
    rig.capture_period_us = 0;
    rig.rest(10);
    EXPECT_NEAR(rig.heading_error(), 0, 0.5 * kDegree);  // 11.5 deg without
}

TEST(Attitude, TakesASlowTurnForABiasOnlyWhileDisarmed) {
    for (const bool armed : {true, false}) {
        AttitudeRig rig;
        rig.has_status = true;
        rig.armed = armed;
        rig.run(20, AttitudeRig::constant({0, 0, 0.02}), kNone);
        EXPECT_EQ(math::abs(rig.heading_error()) < 0.1 * kDegree, armed);
    }
}

TEST(Attitude, DoesNotTakeALargeRateForABias) {
    AttitudeRig rig;
    rig.run(20, AttitudeRig::constant({0, 0, 0.05}), kNone);
    EXPECT_NEAR(rig.heading_error(), 0, 0.1 * kDegree);
}

// 2 m/s^2 to and fro look like 11.5 deg of tilt; the filter lets (1.4 / 3 s / 4 rad/s)^2 of it by.
TEST(Attitude, IsNotTiltedByAccelerations) {
    AttitudeRig rig;
    rig.rest(5);
    const auto shuttle = [](double t) { return Vector(2 * math::cos(4 * t), 0, 0); };
    rig.run(20, kNone, shuttle);
    EXPECT_LT(rig.tilt_rms(), 0.2 * kDegree);
}

TEST(Attitude, AveragesAccelerationsWhileItTurns) {
    AttitudeRig rig;
    rig.rest(5);
    const auto shuttle = [](double t) { return Vector(2 * math::cos(4 * t), 0, 0); };
    rig.run(20, AttitudeRig::constant({0.5, 2, 1}), shuttle);
    EXPECT_LT(rig.tilt_rms(), 0.2 * kDegree);
}

TEST(Attitude, IsNeverTiltedByAMagnet) {
    AttitudeRig plain;
    AttitudeRig magnet;
    magnet.mag_period_us = 10'000;
    magnet.disturbance_B = Vector(0.5, -0.7, 0.9);
    for (AttitudeRig* rig : {&plain, &magnet}) {
        rig->run(20, AttitudeRig::constant({0.2, 0.1, 0.3}), kNone);
    }
    EXPECT_NEAR(magnet.tilt_error(), plain.tilt_error(), 1e-4 * kDegree);
    EXPECT_GT(math::abs(magnet.heading_error()), 5 * kDegree);  // the magnet was felt
}

TEST(Attitude, IgnoresAPassingMagneticDisturbance) {
    AttitudeRig rig;
    rig.mag_period_us = 10'000;
    const auto turning = AttitudeRig::constant({0.3, 0.1, 0.5});
    rig.run(30, turning, kNone);
    EXPECT_NEAR(rig.heading_error(), 0, 0.1 * kDegree);
    rig.disturbance_B = Vector(0.3, 0.1, 0.0);
    rig.run(15, turning, kNone);
    EXPECT_NEAR(rig.heading_error(), 0, 1 * kDegree);
}

TEST(Attitude, BelievesAFieldThatStaysAnotherWhileItMoves) {
    AttitudeRig rig;
    rig.mag_period_us = 10'000;
    const auto turning = AttitudeRig::constant({0.3, 0.1, 0.5});
    rig.run(30, turning, kNone);
    rig.field_N = Vector(0.15, 0.15, 0.1);  // north is elsewhere by 45 deg
    rig.run(18, turning, kNone);
    EXPECT_NEAR(rig.heading_error(), 0, 1 * kDegree);
    rig.run(60, turning, kNone);
    EXPECT_NEAR(rig.heading_error(), 45 * kDegree, 1 * kDegree);
}

TEST(Attitude, FollowsMotionCaptureFromItsFirstSample) {
    AttitudeRig rig;
    rig.q_NB = attitude(10, -15, 120);
    rig.rest(1);
    rig.capture_period_us = 10'000;
    rig.rest(0.02);
    EXPECT_NEAR(rig.heading_error(), 0, 0.05 * kDegree);
}

TEST(Attitude, FollowsMotionCaptureAtOnceAfterAGap) {
    AttitudeRig rig;
    rig.capture_period_us = 10'000;
    rig.rest(5);
    rig.capture_period_us = 0;
    rig.rest(3);
    rig.q_NB = attitude(0, 0, 90);  // as if the reference had been turned
    rig.capture_period_us = 10'000;
    rig.rest(0.02);
    EXPECT_NEAR(rig.heading_error(), 0, 0.05 * kDegree);
    rig.rest(5);
    EXPECT_LT(rig.tilt_rms(), 0.01 * kDegree);
    EXPECT_NEAR(rig.heading_error(), 0, 0.05 * kDegree);
}

TEST(Attitude, TakesNoHeadingFromAVerticalNose) {
    AttitudeRig rig;
    rig.q_NB = attitude(0, 89, 0);
    rig.rest(1);
    const auto before = rig.estimate;
    rig.now_us += 1000;
    const VehicleOdometry seen{.timestamp = rig.now_us,
                               .timestamp_sample = rig.now_us,
                               .position = {},
                               .q = {0.6F, 0, 0, 0.8F}};  // some other heading
    const float nan = std::numeric_limits<float>::quiet_NaN();
    rig.step({.timestamp = rig.now_us, .timestamp_sample = rig.now_us, .xyz = {}},
             {.timestamp = rig.now_us, .timestamp_sample = rig.now_us, .xyz = {nan, 0, 0}}, nullptr,
             &seen);
    EXPECT_LT(rig.estimate.angularDistance(before), 1e-3);
}

TEST(Attitude, PrefersMotionCaptureToTheMagnetometer) {
    AttitudeRig rig;
    rig.mag_period_us = 10'000;
    rig.field_N = Vector(0, 0.2, 0.4);
    rig.capture_period_us = 10'000;
    rig.rest(5);
    EXPECT_NEAR(rig.heading_error(), 0, 0.05 * kDegree);
    rig.capture_period_us = 0;
    rig.rest(60);
    EXPECT_GT(math::abs(rig.heading_error()), 45 * kDegree);
}

TEST(Attitude, LeavesOutSamplesThatAreNoneOrOld) {
    AttitudeRig rig;
    rig.rest(1);
    const auto good = rig.estimate;
    const float nan = std::numeric_limits<float>::quiet_NaN();
    const float infinite = std::numeric_limits<float>::infinity();
    rig.now_us += 1000;
    const SensorGyro gyro{.timestamp = rig.now_us, .timestamp_sample = rig.now_us, .xyz = {}};
    const SensorAccel accel{
        .timestamp = rig.now_us, .timestamp_sample = rig.now_us, .xyz = {0, 0, -9.8F}};
    SensorGyro bad_gyro = gyro;
    bad_gyro.xyz = {nan, 0, 0};
    EXPECT_FALSE(rig.step(bad_gyro, accel));
    bad_gyro.xyz = {3, 0, 0};
    bad_gyro.timestamp_sample -= 1000;
    EXPECT_FALSE(rig.step(bad_gyro, accel));
    SensorAccel bad_accel = accel;
    bad_accel.xyz = {infinite, 0, 0};
    EXPECT_TRUE(rig.step(gyro, bad_accel));
    EXPECT_LT(rig.estimate.angularDistance(good), 1e-5);
    rig.rest(1);
    EXPECT_LT(rig.tilt_error(), 1e-3 * kDegree);
}

TEST(Attitude, FindsGravityAnewAfterAGap) {
    AttitudeRig rig;
    rig.rest(5);
    rig.now_us += 2'000'000;
    rig.q_NB = attitude(40, 0, 0);  // turned while nobody looked
    rig.run(0.02, kNone, kNone);
    EXPECT_LT(rig.tilt_error(), 0.1 * kDegree);
}

// Rest, take-off, hover with gusts, and legs to and fro, as a quadrotor does: it tilts in order to
// accelerate, and what it feels is thrust along its own axis.
TEST(Attitude, KeepsHalfADegreeInGentleFlight) {
    AttitudeRig rig;
    rig.gyro_bias = Vector(0.02, -0.015, 0.02);
    rig.gyro_noise = 0.005;
    rig.accel_noise = 0.2;
    rig.capture_period_us = 10'000;
    rig.has_status = true;
    rig.rest(3);
    rig.armed = true;
    // Pitch p(t) and the acceleration g tan p that goes with it: every 8 s a leg of 0.7 m.
    const auto pitch = [](double t) {
        const double phase = t / 8 - math::floor(t / 8);
        const double amplitude = 3 * kDegree;
        return phase < 0.5 ? amplitude * math::sin(4 * math::kPi<double> * phase) : 0.0;
    };
    const auto rate = [&](double t) {
        return Vector(0, (pitch(t + 0.0005) - pitch(t - 0.0005)) / 0.001, 0);
    };
    const auto acceleration = [&](double t) {
        const double climb = t < 2 ? math::sin(math::kPi<double> * t) : 0.0;
        return Vector(-9.80665 * math::tan(pitch(t)), 0, -climb);
    };
    rig.run(60, rate, acceleration);
    EXPECT_LT(rig.tilt_rms(), 0.5 * kDegree);
    EXPECT_NEAR(rig.heading_error(), 0, 0.5 * kDegree);
}

}  // namespace
}  // namespace stator::apps::attitude
