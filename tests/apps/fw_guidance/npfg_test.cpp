// Path following on an aeroplane that is a point with a bank: onto lines and circles, in wind, and
// in a wind that is stronger than its airspeed.
#include "npfg.hpp"

#include <gtest/gtest.h>

#include "path.hpp"

namespace stator::apps::fw_guidance {
namespace {

constexpr float kGravity = 9.80665F;
constexpr float kDt = 0.02F;
constexpr NpfgGains kGains{.period = 10.0F, .damping = 0.7F};

// Flies at a constant airspeed; the bank follows in 0.5 s.
struct Point {
    Vector2 position = Vector2::Zero();
    float heading = 0.0F;
    float bank = 0.0F;
    Vector2 wind = Vector2::Zero();
    float airspeed = 17.0F;

    Vector2 velocity() const { return airspeed * unit(heading) + wind; }
    void fly(const Path& path) {
        const float wanted = lateral_acceleration(
            path.nearest(position),
            {.position = position, .velocity = velocity(), .wind = wind, .airspeed = airspeed},
            kGains);
        const float angle = math::clamp(math::atan(wanted / kGravity), -0.8F, 0.8F);
        bank += (angle - bank) * (kDt / 0.5F);
        heading += kGravity * math::tan(bank) / airspeed * kDt;
        position += velocity() * kDt;
    }
    void fly(const Path& path, float seconds) {
        for (float t = 0.0F; t < seconds; t += kDt) fly(path);
    }
};

TEST(Npfg, ComesOntoALineWithLittleOvershoot) {
    const Path path = Path::line({0.0F, 0.0F}, {1000.0F, 0.0F}, 0.0F);
    Point plane{.position = {0.0F, -60.0F}, .heading = math::kPi<float>};
    float furthest = 0.0F;
    for (float t = 0.0F; t < 40.0F; t += kDt) {
        plane.fly(path);
        furthest = math::max(furthest, plane.position.y());
    }
    EXPECT_LT(furthest, 5.0F);
    EXPECT_NEAR(plane.position.y(), 0.0F, 0.3F);
    EXPECT_NEAR(math::wrap_pi(plane.heading), 0.0F, 0.02F);
}

// A prototype on the Ultra Stick 25e with perfect states: 0.15 m rms calm, 0.51 m in 8 m/s of wind.
TEST(Npfg, KeepsToACircle) {
    for (const float wind : {0.0F, 8.0F}) {
        for (const float radius : {80.0F, -80.0F}) {
            const Path path = Path::circle({0.0F, 0.0F}, radius);
            Point plane{.position = {-150.0F, 0.0F}, .wind = {wind, 0.0F}};
            plane.fly(path, 60.0F);
            double sum = 0.0;
            unsigned count = 0;
            for (float t = 0.0F; t < 60.0F; t += kDt, ++count) {
                plane.fly(path);
                const float off = math::norm(plane.position) - 80.0F;
                sum += static_cast<double>(off * off);
            }
            const double rms = math::sqrt(sum / count);
            EXPECT_LT(rms, wind == 0.0F ? 0.3 : 1.0) << wind << " " << radius;
        }
    }
}

TEST(Npfg, CrabsAlongALineInACrosswind) {
    const Path path = Path::line({0.0F, 0.0F}, {1000.0F, 0.0F}, 0.0F);
    Point plane{.wind = {0.0F, 8.0F}};
    plane.fly(path, 40.0F);
    EXPECT_NEAR(plane.position.y(), 0.0F, 0.5F);
    // sin(crab) = 8/17: 28.1 deg into the wind.
    EXPECT_NEAR(plane.heading, -0.490F, 0.02F);
}

// Publicly reported: in a wind above the airspeed aeroplanes turned for ever, and three were lost.
// The nose goes into the wind; what is left is 20 - 17 = 3 m/s straight back.
TEST(Npfg, InAWindAboveItsAirspeedItTurnsTheNoseIntoIt) {
    const Path path = Path::circle({0.0F, 0.0F}, 80.0F);
    Point plane{.position = {-80.0F, 0.0F}, .heading = 1.0F, .wind = {0.0F, -20.0F}};
    plane.fly(path, 60.0F);
    const Vector2 before = plane.position;
    plane.fly(path, 60.0F);
    const Vector2 drift = (plane.position - before) / 60.0F;
    EXPECT_NEAR(drift.y(), -3.0F, 0.3F);
    EXPECT_LT(math::abs(drift.x()), 5.0F / 60.0F + 0.2F);
    EXPECT_LT(math::abs(plane.bank), 0.09F);
}

}  // namespace
}  // namespace stator::apps::fw_guidance
