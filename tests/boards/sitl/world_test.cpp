// What happens when in the simulated world, and what is seen of the flight.
#include "world.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "truth.hpp"

namespace stator::board {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr std::array<float, kRotors> kStopped{kNan, kNan, kNan, kNan};

std::array<float, kRotors> all(float control) {
    return {control, control, control, control};
}

void run_until(World& world, std::uint64_t time_us) {
    while (world.next_event_us() <= time_us) world.move_to_next_event();
}

TEST(World, imu_samples_at_time_zero_and_each_millisecond) {
    World world{Conditions{}};
    EXPECT_EQ(world.next_event_us(), 0U);
    for (std::uint64_t time_us = 0; time_us <= 20000; time_us += 1000) {
        EXPECT_EQ(world.next_event_us(), time_us);
        EXPECT_TRUE(world.move_to_next_event().imu);
        EXPECT_EQ(world.plant().time_us(), time_us);
    }
}

TEST(World, sensors_and_radio_have_their_rates) {
    World world{Conditions{}};
    unsigned mag = 0;
    unsigned baro = 0;
    unsigned radio = 0;
    while (world.next_event_us() < 1000000) {
        const World::Event event = world.move_to_next_event();
        mag += event.mag_B ? 1U : 0U;
        baro += event.baro ? 1U : 0U;
        radio += event.radio ? 1U : 0U;
    }
    EXPECT_EQ(mag, 100U);
    EXPECT_EQ(baro, 50U);
    EXPECT_EQ(radio, 50U);
}

// Of all fixes in `seconds`: arrival and time of the fix.
std::vector<std::pair<std::uint64_t, GnssFix>> fixes(World& world, std::uint64_t seconds) {
    std::vector<std::pair<std::uint64_t, GnssFix>> result;
    while (world.next_event_us() < seconds * 1000000) {
        const World::Event event = world.move_to_next_event();
        if (event.gnss) result.emplace_back(world.plant().time_us(), *event.gnss);
    }
    return result;
}

TEST(World, fixes_arrive_about_110_ms_late_and_some_never) {
    World world{Conditions{}};
    const auto all_fixes = fixes(world, 200);
    double sum_us = 0.0;
    for (const auto& [arrival_us, fix] : all_fixes) {
        const std::uint64_t delay_us = arrival_us - fix.time_us;
        EXPECT_GE(delay_us, 90000U);
        EXPECT_LE(delay_us, 130000U);
        sum_us += static_cast<double>(delay_us);
    }
    EXPECT_NEAR(sum_us / static_cast<double>(all_fixes.size()), 110000.0, 2000.0);
    // 5 Hz; of 1000 fixes, 5 are lost on average.
    EXPECT_LT(all_fixes.size(), 999U);
    EXPECT_GT(all_fixes.size(), 985U);
}

TEST(World, faults_come_and_go) {
    Conditions conditions;
    ASSERT_TRUE(conditions.faults.add({FaultKind::kGnssLoss, 0.0, 2000000, 4000000}));
    ASSERT_TRUE(conditions.faults.add({FaultKind::kRcLoss, 0.0, 1000000, 3000000}));
    ASSERT_TRUE(conditions.faults.add({FaultKind::kBatteryLow, 0.1, 2000000, 2000001}));
    World world(conditions);
    while (world.next_event_us() < 6000000) {
        const World::Event event = world.move_to_next_event();
        const std::uint64_t now_us = world.plant().time_us();
        if (event.gnss) {
            const bool lost = event.gnss->time_us >= 2000000 && event.gnss->time_us < 4000000;
            EXPECT_EQ(event.gnss->satellites == 0, lost);
        }
        if (event.radio) {
            EXPECT_EQ(event.radio->is_heard, now_us < 1000000 || now_us >= 3000000);
        }
        if (now_us < 2000000) {
            EXPECT_GT(world.battery().remaining(), 0.99);
        }
    }
    EXPECT_LE(world.battery().remaining(), 0.1);  // for good
}

TEST(World, a_glitch_pulls_the_fix_away_level) {
    Conditions conditions;
    World well(conditions);
    ASSERT_TRUE(conditions.faults.add({FaultKind::kGnssGlitch, 25.0, 0, 1000000}));
    World pulled(conditions);
    const Geodetic a = fixes(well, 1).front().second.place;
    const Geodetic b = fixes(pulled, 1).front().second.place;
    // 111.2 km are a degree of latitude here, 75.5 km one of longitude (WGS 84, to 0.1 %).
    const double north = (b.latitude_deg - a.latitude_deg) * 111170.0;
    const double east = (b.longitude_deg - a.longitude_deg) * 75500.0;
    EXPECT_NEAR(std::hypot(north, east), 25.0, 0.1);
    EXPECT_EQ(a.altitude_msl, b.altitude_msl);
}

TEST(World, a_broken_propeller_thrusts_less) {
    Conditions conditions;
    ASSERT_TRUE(conditions.faults.add({FaultKind::kMotor1, 0.5, 0, 1000000}));
    World world(conditions);
    world.move_to_next_event();
    world.command_motors(0, all(0.9F));
    run_until(world, 300000);
    // The front right one: the vehicle rolls right and pitches down.
    EXPECT_GT(world.plant().state().rate_B.x(), 0.5);
    EXPECT_LT(world.plant().state().rate_B.y(), -0.3);
}

TEST(World, motion_capture_arrives_late_with_the_time_of_its_picture) {
    World world{Conditions{}};
    std::vector<std::pair<std::uint64_t, std::uint64_t>> arrivals;
    while (world.next_event_us() <= 30000) {
        const World::Event event = world.move_to_next_event();
        if (event.mocap) arrivals.emplace_back(world.plant().time_us(), event.mocap->time_us);
    }
    const decltype(arrivals) expected{{5000, 0}, {15000, 10000}, {25000, 20000}};
    EXPECT_EQ(arrivals, expected);
}

TEST(World, motion_capture_shows_where_the_vehicle_was_at_the_picture) {
    World world{Conditions{}};
    world.move_to_next_event();
    world.command_motors(0, all(1.0F));
    run_until(world, 504000);
    const double z_then = [&] {
        World same{Conditions{}};
        same.move_to_next_event();
        same.command_motors(0, all(1.0F));
        run_until(same, 500000);
        return same.plant().state().position_N.z();
    }();
    const World::Event event = world.move_to_next_event();
    ASSERT_TRUE(event.mocap);
    EXPECT_NEAR(static_cast<double>(event.mocap->position_N.z()), z_then, 0.005);
    EXPECT_LT(world.plant().state().position_N.z(), z_then - 0.01);  // it has climbed since
}

TEST(World, command_acts_from_its_instant_on) {
    World world{Conditions{}};
    world.move_to_next_event();
    world.command_motors(300, all(1.0F));
    world.move_to_next_event();
    // A full battery without load has 12.31 V, where 11.877 V give 1100 rad/s.
    const double expected = 1100.0 * 12.308 / 11.877 * (1.0 - std::exp(-700e-6 / 0.0125));
    EXPECT_NEAR(world.plant().state().rotor_speeds[2], expected, 0.1);
}

TEST(World, flight_is_a_function_of_its_seed) {
    const auto end = [](std::uint64_t seed) {
        World world(Conditions{.seed = seed});
        world.move_to_next_event();
        world.command_motors(0, all(0.6F));
        Vector3f sum = Vector3f::Zero();
        while (world.next_event_us() <= 200000) {
            const World::Event event = world.move_to_next_event();
            sum += event.imu->gyro_B + event.imu->accel_B;
            if (event.mag_B) sum += *event.mag_B;
        }
        return sum;
    };
    EXPECT_EQ(end(5), end(5));
    EXPECT_NE(end(5), end(6));
}

TEST(World, sees_a_whole_flight) {
    World world{Conditions{}};
    world.move_to_next_event();
    world.command_motors(0, all(0.7F));
    run_until(world, 1000000);
    ASSERT_TRUE(world.watch().take_off_us());
    EXPECT_LT(*world.watch().take_off_us(), 100000U);
    EXPECT_FALSE(world.watch().touchdown());
    const double height = -world.plant().state().position_N.z();
    const double climb_speed = -world.plant().state().velocity_N.z();
    world.command_motors(1000000, all(0.0F));
    run_until(world, 4000000);
    ASSERT_TRUE(world.watch().touchdown());
    // A fall from the highest point: v^2 = climb speed^2 + 2 g height, less some drag.
    const double speed = std::sqrt(climb_speed * climb_speed + 2.0 * 9.80665 * height);
    EXPECT_NEAR(world.watch().touchdown()->speed, speed, 0.05 * speed);
    EXPECT_FALSE(world.is_over());  // commanded to zero is not stopped
    world.command_motors(4000000, kStopped);
    run_until(world, 5000000);
    EXPECT_FALSE(world.is_over());
    run_until(world, 5001000);
    EXPECT_TRUE(world.is_over());
}

TEST(World, standing_with_stopped_motors_is_not_the_end_of_a_flight) {
    World world{Conditions{}};
    world.move_to_next_event();
    world.command_motors(0, kStopped);
    run_until(world, 3000000);
    EXPECT_FALSE(world.is_over());
    EXPECT_FALSE(world.watch().take_off_us());
}

TEST(World, a_varied_vehicle_hears_its_commands_late) {
    const auto first_turn_us = [](std::uint64_t seed) {
        World world(Conditions{.seed = seed, .vary = true});
        world.move_to_next_event();
        world.command_motors(0, all(1.0F));
        while (world.plant().state().rotor_speeds[0] == 0.0) world.move_to_next_event();
        return world.plant().time_us();
    };
    const std::uint64_t delay_us = vary(Variation{}, 3).command_delay_us;
    EXPECT_GT(delay_us, 1000U);  // else this seed tells nothing
    EXPECT_EQ(first_turn_us(3), delay_us / 1000 * 1000 + 1000);
}

TEST(World, wind_acts_on_the_plant) {
    World world(Conditions{.wind = {.speed = 5.0, .from = 0.0}});
    world.move_to_next_event();
    EXPECT_NEAR((world.plant().influence().wind_N - Vector3(-5.0, 0.0, 0.0)).norm(), 0.0, 1e-12);
}

TEST(Truth, names_its_columns_and_holds_the_state) {
    World world(Conditions{.wind = {.speed = 5.0, .from = 0.0}});
    run_until(world, 3000);
    std::FILE* const file = std::tmpfile();
    ASSERT_TRUE(write_truth_head(file));
    const long head = std::ftell(file);
    EXPECT_EQ(head % 8, 0);
    ASSERT_TRUE(write_truth(file, world));
    std::rewind(file);
    std::string line(static_cast<std::size_t>(head), ' ');
    EXPECT_EQ(std::fread(line.data(), 1, line.size(), file), line.size());
    EXPECT_EQ(line.substr(0, 42), "time_us position_n position_e position_d v");
    EXPECT_EQ(line.back(), '\n');
    std::array<double, kTruthColumns.size() + 1> row{};
    EXPECT_EQ(std::fread(row.data(), sizeof(double), row.size(), file), kTruthColumns.size());
    const auto column = [&](const std::string& name) {
        const auto* const found = std::find(kTruthColumns.begin(), kTruthColumns.end(), name);
        return row[static_cast<std::size_t>(found - kTruthColumns.begin())];
    };
    const QuadState& state = world.plant().state();
    EXPECT_EQ(column("time_us"), 3000.0);
    EXPECT_EQ(column("position_e"), state.position_N.y());
    EXPECT_EQ(column("velocity_d"), state.velocity_N.z());
    EXPECT_EQ(column("q_w"), state.q_NB.w());
    EXPECT_EQ(column("q_z"), state.q_NB.z());
    EXPECT_EQ(column("rate_x"), state.rate_B.x());
    EXPECT_EQ(column("on_ground"), 1.0);
    EXPECT_EQ(column("wind_n"), -5.0);
    EXPECT_EQ(column("rotor_4"), 0.0);
    EXPECT_EQ(column("voltage_v"), world.battery().voltage());
    EXPECT_EQ(column("remaining"), world.battery().remaining());
    EXPECT_EQ(std::fclose(file), 0);
}

}  // namespace
}  // namespace stator::board
