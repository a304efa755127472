// Navigation against a vehicle whose motion is known.
#include "navigation.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "rig.hpp"

namespace stator::apps::navigation {
namespace {

using testing::NavigationRig;

constexpr double kDegree = math::kPi<double> / 180;

// A fast figure of eight: 5 m/s, 4 m/s^2.
NavigationRig flying(uint64_t seed = 1) {
    NavigationRig rig(seed);
    rig.amplitude = 12;
    return rig;
}

TEST(Navigation, SaysNothingBeforeLevelIsKnown) {
    NavigationRig rig;
    rig.run(0.28);
    EXPECT_EQ(rig.attitudes, 0U);
    rig.run(0.1);
    EXPECT_GT(rig.attitudes, 0U);
    EXPECT_FALSE(rig.position.xy_valid);
}

TEST(Navigation, KnowsWhereItIsAtRest) {
    NavigationRig rig;
    rig.run(20);
    EXPECT_LT(rig.tilt_error(), 0.3 * kDegree);
    EXPECT_NEAR(rig.heading_error(), 0, 1 * kDegree);
    EXPECT_LT(rig.velocity_error().norm(), 0.2);
    EXPECT_LT(rig.position_error().norm(), 0.6);
    EXPECT_TRUE(rig.position.xy_valid && rig.position.z_valid && rig.position.v_xy_valid);
    EXPECT_TRUE(rig.position.xy_global && rig.position.z_global);
    EXPECT_TRUE(rig.position.heading_good_for_control);
    EXPECT_FALSE(rig.position.dead_reckoning);
    EXPECT_NEAR(rig.position.ref_lat, 47.4, 2e-5);
    EXPECT_NEAR(rig.position.ref_alt, 500, 6);
    EXPECT_LE(rig.status.late_measurements, 3U);  // those from before level was known
}

TEST(Navigation, FollowsAFastFlight) {
    NavigationRig rig = flying();
    rig.run(60);
    double tilt = 0;
    double velocity = 0;
    double position = 0;
    for (int i = 0; i < 100; ++i) {
        rig.run(0.2);
        tilt = std::max(tilt, rig.tilt_error());
        velocity = std::max(velocity, rig.velocity_error().norm());
        position = std::max(position, rig.position_error().head<2>().norm());
    }
    EXPECT_LT(tilt, 0.8 * kDegree);
    EXPECT_LT(velocity, 0.3);
    EXPECT_LT(position, 0.8);
}

TEST(Navigation, FindsItsBiases) {
    NavigationRig rig = flying();
    rig.gyro_bias = {0.01, -0.02, 0.015};
    rig.accel_bias = {0.15, -0.1, 0.2};
    rig.params.accel_bias_uncertainty = 0.2F;  // of an accelerometer that nobody calibrated
    rig.yaw_rate = 0.3;
    rig.run(180);
    for (int i = 0; i < 3; ++i) {
        EXPECT_NEAR(rig.bias.gyro_bias[static_cast<unsigned>(i)], rig.gyro_bias(i), 0.004);
        EXPECT_NEAR(rig.bias.accel_bias[static_cast<unsigned>(i)], rig.accel_bias(i), 0.05);
    }
}

// It starts while something pushes: gravity seems to point elsewhere by 17 degrees.
TEST(Navigation, ConvergesFromAWrongTilt) {
    NavigationRig rig = flying();
    rig.push_N = {3, 0, 0};
    rig.run(0.4);
    EXPECT_GT(rig.tilt_error(), 12 * kDegree);
    rig.push_N = {0, 0, 0};
    rig.run(25);
    EXPECT_LT(rig.tilt_error(), 1.5 * kDegree);
}

// A magnetometer that is mounted the wrong way round: satellites find the heading all the same.
class WrongHeading : public ::testing::TestWithParam<double> {};
TEST_P(WrongHeading, ConvergesInFlight) {
    NavigationRig rig = flying();
    rig.mag_turn = GetParam() * kDegree;
    rig.run(4);
    EXPECT_NEAR(std::abs(rig.heading_error()), std::abs(GetParam()) * kDegree, 5 * kDegree);
    rig.run(56);
    EXPECT_NEAR(rig.heading_error(), 0, 5 * kDegree);
    EXPECT_NEAR(std::abs(rig.bias.mag_offset), std::abs(GetParam()) * kDegree, 6 * kDegree);
    EXPECT_LT(rig.tilt_error(), 2.5 * kDegree);
}
INSTANTIATE_TEST_SUITE_P(Degrees, WrongHeading, ::testing::Values(20.0, -60.0, 120.0, -170.0));

TEST(Navigation, FindsTheHeadingWithoutAMagnetometer) {
    NavigationRig rig = flying();
    rig.has_mag = false;
    rig.start_yaw = 2.0;
    rig.run(4);
    EXPECT_FALSE(rig.position.heading_good_for_control);
    rig.run(20);
    EXPECT_NEAR(rig.heading_error(), 0, 4 * static_cast<double>(rig.status.heading_accuracy));
    EXPECT_NEAR(rig.heading_error(), 0, 3 * kDegree);
    EXPECT_TRUE(rig.position.heading_good_for_control);
}

// Some receivers say 0 deg, 0 deg before they know.
TEST(Navigation, AFirstFixAtZeroZeroIsNone) {
    NavigationRig rig;
    rig.is_nowhere = true;
    rig.run(5);
    EXPECT_FALSE(rig.position.xy_global);
    EXPECT_FALSE(rig.position.xy_valid);
    rig.is_nowhere = false;
    rig.run(15);
    EXPECT_TRUE(rig.position.xy_valid);
    EXPECT_NEAR(rig.position.ref_lat, 47.4, 2e-5);
    EXPECT_LT(rig.position_error().norm(), 0.8);
}

// A clock that runs ahead: what was measured later than now was not measured then.
TEST(Navigation, AFixFromTheFutureIsLeftOut) {
    NavigationRig rig = flying();
    rig.run(20);
    rig.fixes_ahead_us = 900'000;
    rig.run(20);
    EXPECT_FALSE(rig.position.xy_valid);
    EXPECT_LT(rig.tilt_error(), 3 * kDegree);
}

// Without IMU samples nothing is known, and that is said.
TEST(Navigation, ASilentImuIsSaid) {
    NavigationRig rig;
    rig.run(10);
    EXPECT_TRUE(rig.position.xy_valid && rig.position.z_valid && rig.position.v_z_valid);
    rig.has_imu = false;
    rig.run(0.3);
    EXPECT_FALSE(rig.position.xy_valid || rig.position.z_valid || rig.position.v_z_valid ||
                 rig.position.v_xy_valid || rig.position.heading_good_for_control);
    rig.has_imu = true;
    rig.run(1);
    EXPECT_TRUE(rig.position.xy_valid && rig.position.z_valid && rig.position.v_z_valid);
}

// A receiver whose velocity is not how its positions change: the estimate says that it is unsure.
TEST(Navigation, AReceiverThatContradictsItselfIsDoubted) {
    NavigationRig rig;
    rig.run(20);
    const float sure = rig.position.evh;
    rig.velocity_error_N = {0, 2.5, 0};
    rig.run(4);
    EXPECT_GT(rig.position.evh, 3 * sure);
    EXPECT_LT(rig.velocity_error().head<2>().norm(), 5 * static_cast<double>(rig.position.evh));
}

// A velocity that turns wrong carries the position away, and the error that is said.
TEST(Navigation, AVelocityThatDriftsMakesThePositionUnsure) {
    NavigationRig rig;
    rig.params.gnss_position_noise = 4.0F;
    rig.run(20);
    for (int fix = 1; fix <= 40; ++fix) {
        rig.velocity_error_N = Eigen::Vector3d(0.3, 0, 0) * fix;
        rig.run(0.2);
        const double error = rig.position_error().head<2>().norm();
        EXPECT_LT(error, 1.6 * static_cast<double>(rig.position.eph)) << fix;
    }
}

// A position that jumps by less than the gate is followed; the error that is said grows with it.
TEST(Navigation, AJumpThatIsFollowedIsInTheErrorThatIsSaid) {
    NavigationRig rig;
    rig.params.gnss_position_noise = 4.0F;
    rig.run(20);
    rig.glitch_N = {15, 0, 0};
    rig.run(40);
    EXPECT_GT(rig.position.eph, 4.0F);
    rig.glitch_N = {0, 0, 0};
    rig.run(60);
    EXPECT_LT(rig.position.eph, 3.0F);
}

// Without acceleration nothing shows the heading but the magnetometer, whatever the noise.
TEST(Navigation, LearnsNoHeadingFromNoise) {
    NavigationRig rig;
    rig.run(3);
    const float before = rig.status.heading_accuracy;
    rig.run(90);
    EXPECT_NEAR(rig.heading_error(), 0, 1 * kDegree);
    EXPECT_GT(rig.status.heading_accuracy, 0.9F * before);
}

// In flight, where heading and tilt are correlated; beside the same flight without disturbance.
TEST(Navigation, TheMagnetometerNeverTilts) {
    NavigationRig calm = flying();
    NavigationRig disturbed = flying();
    for (NavigationRig* rig : {&calm, &disturbed}) {
        rig->run(8);
        rig->has_gnss = false;
    }
    disturbed.mag_turn = 0.3;
    calm.run(0.6);
    disturbed.run(0.6);
    EXPECT_GT(std::abs(disturbed.heading_error() - calm.heading_error()), 0.2 * kDegree);
    EXPECT_NEAR(disturbed.tilt_error(), calm.tilt_error(), 0.02 * kDegree);
}

// What arrives earlier waits until the horizon has come: to the bit, the delay makes no difference.
TEST(Navigation, ADelayWithinTheHorizonChangesNothing) {
    NavigationRig late = flying();
    NavigationRig early = flying();
    late.gnss_delay_us = 160'000;
    early.gnss_delay_us = 0;
    for (NavigationRig* rig : {&late, &early}) {
        rig->has_gnss = false;  // so that both have the same first fix
        rig->run(1);
        rig->has_gnss = true;
        rig->run(30);
    }
    EXPECT_EQ(late.attitude.q, early.attitude.q);
    EXPECT_EQ(late.position.x, early.position.x);
    EXPECT_EQ(late.position.vy, early.position.vy);
}

TEST(Navigation, TheHorizonItselfHardlyMatters) {
    NavigationRig behind = flying();
    NavigationRig now = flying();
    now.gnss_delay_us = behind.gnss_delay_us = 0;
    behind.params.fusion_delay = 0.4F;
    now.params.fusion_delay = 0.0F;
    behind.run(60);
    now.run(60);
    EXPECT_NEAR(behind.position.x, now.position.x, 0.3);
    EXPECT_NEAR(behind.position.vx, now.position.vx, 0.15);
    EXPECT_LT(behind.tilt_error(), 0.6 * kDegree);
    EXPECT_LT(now.tilt_error(), 0.6 * kDegree);
}

TEST(Navigation, LeavesAGlitchOut) {
    NavigationRig rig = flying();
    rig.run(40);
    rig.glitch_N = {60, -40, 0};
    rig.run(3);
    EXPECT_LT(rig.position_error().head<2>().norm(), 1.5);
    EXPECT_GT(rig.status.pos_test_ratio, 1);
    rig.glitch_N = {0, 0, 0};
    rig.run(5);
    EXPECT_LT(rig.position_error().head<2>().norm(), 1.0);
    EXPECT_EQ(rig.position.xy_reset_counter, 1);  // the first fix
}

TEST(Navigation, BelievesWhatStays) {
    NavigationRig rig;
    rig.run(20);
    rig.glitch_N = {60, -40, 0};
    rig.run(8);
    EXPECT_NEAR(rig.position_error().x(), 60, 2);
    EXPECT_NEAR(rig.position_error().y(), -40, 2);
    EXPECT_EQ(rig.position.xy_reset_counter, 2);
    EXPECT_NEAR(rig.position.delta_xy[0], 60, 3);
}

TEST(Navigation, GoesOnWithoutSatellites) {
    NavigationRig rig = flying();
    rig.run(60);
    rig.has_gnss = false;
    rig.run(3);
    EXPECT_TRUE(rig.position.xy_valid && rig.position.dead_reckoning);
    EXPECT_LT(rig.position_error().head<2>().norm(), 3.0);
    rig.run(60);
    EXPECT_FALSE(rig.position.xy_valid || rig.position.v_xy_valid);
    EXPECT_TRUE(rig.position.z_valid);
    EXPECT_LT(rig.tilt_error(), 6 * kDegree);
    EXPECT_NEAR(rig.position_error().z(), 0, 1.5);
    rig.has_gnss = true;
    rig.run(20);
    EXPECT_TRUE(rig.position.xy_valid);
    EXPECT_LT(rig.position_error().head<2>().norm(), 1.0);
    EXPECT_LT(rig.tilt_error(), 1 * kDegree);
}

// With a heading that may be any it does not know where it goes.
TEST(Navigation, WithoutSatellitesAndHeadingThePositionIsLostSoon) {
    NavigationRig rig;
    rig.has_mag = false;
    rig.run(20);
    ASSERT_FALSE(rig.position.heading_good_for_control);
    EXPECT_TRUE(rig.position.xy_valid);
    rig.has_gnss = false;
    rig.run(2);
    EXPECT_FALSE(rig.position.xy_valid || rig.position.v_xy_valid);
}

TEST(Navigation, KnowsHeightWithoutABarometer) {
    NavigationRig rig = flying();
    rig.has_baro = false;
    rig.run(30);
    EXPECT_TRUE(rig.position.z_valid);
    EXPECT_NEAR(rig.position_error().z(), 0, 3);
}

TEST(Navigation, NeverHadSatellitesNorMagnetometer) {
    NavigationRig rig;
    rig.has_gnss = rig.has_mag = false;
    rig.gyro_bias = {0.01, 0.01, 0};
    rig.run(60);
    EXPECT_FALSE(rig.position.xy_valid || rig.position.xy_global);
    EXPECT_TRUE(rig.position.z_valid);
    EXPECT_LT(rig.tilt_error(), 1 * kDegree);
}

TEST(Navigation, TheOutputDoesNotJump) {
    NavigationRig rig = flying();
    rig.run(30);
    float worst = 0;
    for (int i = 0; i < 2500; ++i) {
        const VehicleLocalPosition before = rig.position;
        rig.run(0.004);
        const float moved = rig.position.x - before.x;
        const float expected = 0.002F * (rig.position.vx + before.vx);
        worst = std::max(worst, std::abs(moved - expected));
    }
    EXPECT_LT(worst, 0.015F);
}

TEST(Navigation, BadSamplesAreLeftOut) {
    NavigationRig rig;
    rig.run(10);
    const float nan = std::numeric_limits<float>::quiet_NaN();
    rig.now_us += 4000;
    const SensorGyro gyro{.timestamp_sample = rig.now_us, .xyz = {0, nan, 0}};
    const SensorAccel accel{.timestamp_sample = rig.now_us, .xyz = {nan, 0, 0}};
    const SensorGps fix{.timestamp_sample = rig.now_us,
                        .latitude_deg = std::numeric_limits<double>::quiet_NaN(),
                        .fix_type = SensorGps::FixType::kFix3d};
    const SensorBaro baro{.timestamp_sample = rig.now_us, .pressure = nan};
    const SensorMag mag{.timestamp_sample = rig.now_us, .xyz = {nan, nan, nan}};
    rig.activate(gyro, accel, &fix, &baro, &mag);
    const SensorGyro old{.timestamp_sample = rig.now_us - 100'000, .xyz = {3, 3, 3}};
    rig.activate(old, accel, nullptr, nullptr, nullptr);
    rig.run(5);
    EXPECT_LT(rig.tilt_error(), 0.3 * kDegree);
    EXPECT_LT(rig.position_error().norm(), 1.0);
}

// Each step is longer than a fix may wait, so that one is given up after its first axis.
TEST(Navigation, AFixAfterADroppedOneBeginsAnew) {
    constexpr uint64_t kStep_us = 150'000;
    NavigationRig rig;
    rig.run(10);
    rig.params.fusion_delay = 100;  // the horizon moves only as the window overflows
    const auto activate = [&rig](const SensorGps* fix = nullptr) {
        const SensorGyro gyro{.timestamp_sample = rig.now_us};
        const SensorAccel accel{.timestamp_sample = rig.now_us, .xyz = {0, 0, -kGravity}};
        rig.activate(gyro, accel, fix, nullptr, nullptr);
    };
    const auto step = [&](unsigned count) {
        for (unsigned i = 0; i < count; ++i) {
            rig.now_us += kStep_us;
            activate();
        }
    };
    step(MotionWindow::kCapacity);
    SensorGps fix{.timestamp_sample = rig.now_us,
                  .latitude_deg = 47.4,
                  .longitude_deg = 8.5,
                  .altitude_msl_m = 500,
                  .s_variance_m_s = 0.1F,
                  .eph = 0.5F,
                  .epv = 2.0F,
                  .fix_type = SensorGps::FixType::kFix3d,
                  .vel_ned_valid = true};
    activate(&fix);
    step(1);
    fix.timestamp_sample = rig.now_us;
    fix.vel_n_m_s = 1;
    activate(&fix);
    step(MotionWindow::kCapacity - 1);
    for (int i = 0; i < 6; ++i) activate();
    ASSERT_EQ(rig.innovations.timestamp_sample, fix.timestamp_sample);
    EXPECT_NEAR(rig.innovations.gps_hvel[0], 1, 0.2);
}

TEST(Navigation, StartsAnewAfterAGap) {
    NavigationRig rig;
    rig.run(10);
    rig.now_us += 3'000'000;
    rig.start_yaw = -1.0;
    rig.run(0.2);
    rig.run(10);
    EXPECT_NEAR(rig.heading_error(), 0, 2 * kDegree);
    EXPECT_LT(rig.tilt_error(), 0.3 * kDegree);
    EXPECT_TRUE(rig.position.xy_valid);
}

// With noise as the filter takes it to be, the errors have the size that it says, and so have the
// innovations: mean of the squares over many flights, against 1.
TEST(Navigation, KnowsHowWellItKnows) {
    double horizontal = 0;
    double velocity = 0;
    double tilt = 0;
    double height_innovation = 0;
    double count = 0;
    for (uint64_t seed = 1; seed <= 12; ++seed) {
        NavigationRig rig = flying(seed);
        rig.gnss_velocity_noise = static_cast<double>(rig.params.gnss_velocity_noise);
        rig.gnss_position_noise = static_cast<double>(rig.params.gnss_position_noise);
        rig.baro_noise = static_cast<double>(rig.params.baro_noise);
        rig.params.gnss_slow_error = 0.0F;  // this world has none
        rig.run(40);
        for (int i = 0; i < 40; ++i) {
            rig.run(1);
            const auto square = [](double error, float sigma) {
                return math::square(error / static_cast<double>(sigma));
            };
            velocity += square(rig.velocity_error().head<2>().norm(), rig.position.evh);
            horizontal += square(rig.position_error().head<2>().norm(), rig.position.eph);
            tilt += square(rig.tilt_error(), rig.status.tilt_accuracy);
            height_innovation += static_cast<double>(rig.status.hgt_test_ratio) *
                                 math::square(static_cast<double>(rig.params.gate));
            count += 1;
        }
    }
    // The output is predicted over 0.2 s and smoothed, which costs a little.
    EXPECT_GT(velocity / count, 0.5);
    EXPECT_LT(velocity / count, 1.7);
    EXPECT_GT(horizontal / count, 0.3);
    EXPECT_LT(horizontal / count, 1.7);
    EXPECT_GT(tilt / count, 0.3);
    EXPECT_LT(tilt / count, 1.7);
    EXPECT_NEAR(height_innovation / count, 1.0, 0.25);
}

}  // namespace
}  // namespace stator::apps::navigation
