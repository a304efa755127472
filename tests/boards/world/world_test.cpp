// What happens when in the simulated world, and what is seen of the flight.
#include "world/world.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "drivers/baro/sim/baro_sim_world.hpp"
#include "drivers/battery/sim/battery_sim_world.hpp"
#include "drivers/gnss/sim/gnss_sim_world.hpp"
#include "drivers/imu/sim/imu_sim_world.hpp"
#include "drivers/mag/sim/mag_sim_world.hpp"
#include "drivers/mocap/sim/mocap_sim_world.hpp"
#include "drivers/radio/sim/radio_sim_world.hpp"
#include "iris.hpp"
#include "world/truth.hpp"

namespace stator::world {
namespace {

using drivers::baro::sim::BaroSimWorld;
using drivers::battery::sim::BatterySimWorld;
using drivers::gnss::sim::GnssSimSample;
using drivers::gnss::sim::GnssSimWorld;
using drivers::imu::sim::ImuSimWorld;
using drivers::mag::sim::MagSimWorld;
using drivers::mocap::sim::MocapSimWorld;
using drivers::radio::sim::RadioSimWorld;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
Controls all(float control) {
    Controls controls;
    controls.fill(control);
    return controls;
}

const Controls kStopped = all(kNan);

void run_until(World& world, std::uint64_t time_us) {
    while (world.next_event_us() <= time_us) world.move_to_next_event();
}

// Calls `see(sample)` with all that a part measures in `seconds`.
template <class Part, class See>
void watch(World& world, Part part, std::uint64_t seconds, const See& see) {
    while (world.next_event_us() < seconds * 1000000) {
        world.move_to_next_event();
        if (const auto sample = part.measure(world)) see(*sample);
    }
}

template <class Part>
unsigned samples_of_a_second() {
    World world{Conditions{}, iris()};
    unsigned count = 0;
    watch(world, Part(world), 1, [&](const auto&) { ++count; });
    return count;
}

TEST(World, imu_samples_at_time_zero_and_each_millisecond) {
    World world{Conditions{}, iris()};
    ImuSimWorld imu(world);
    EXPECT_EQ(world.next_event_us(), 0U);
    for (std::uint64_t time_us = 0; time_us <= 20000; time_us += 1000) {
        EXPECT_EQ(world.next_event_us(), time_us);
        world.move_to_next_event();
        EXPECT_EQ(world.time_us(), time_us);
        const auto sample = imu.measure(world);
        ASSERT_TRUE(sample);
        EXPECT_EQ(sample->timestamp_sample, time_us);
    }
}

TEST(World, sensors_and_radio_have_their_rates) {
    EXPECT_EQ(samples_of_a_second<MagSimWorld>(), 100U);
    EXPECT_EQ(samples_of_a_second<BaroSimWorld>(), 50U);
    EXPECT_EQ(samples_of_a_second<RadioSimWorld>(), 50U);
    EXPECT_EQ(samples_of_a_second<BatterySimWorld>(), 20U);
}

// Of all fixes in `seconds`: arrival and fix.
std::vector<std::pair<std::uint64_t, GnssSimSample>> fixes(World& world, std::uint64_t seconds) {
    std::vector<std::pair<std::uint64_t, GnssSimSample>> result;
    watch(world, GnssSimWorld(world), seconds,
          [&](const GnssSimSample& fix) { result.emplace_back(world.time_us(), fix); });
    return result;
}

TEST(World, fixes_arrive_about_110_ms_late_and_some_never) {
    World world{Conditions{}, iris()};
    const auto all_fixes = fixes(world, 200);
    double sum_us = 0.0;
    for (const auto& [arrival_us, fix] : all_fixes) {
        const std::uint64_t delay_us = arrival_us - fix.timestamp_sample;
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
    ASSERT_TRUE(conditions.faults.add({FaultKind::kBaroLoss, 0.0, 1000000, 2000000}));
    World world{conditions, iris()};
    GnssSimWorld gnss(world);
    RadioSimWorld radio(world);
    BaroSimWorld baro(world);
    unsigned pressures = 0;
    while (world.next_event_us() < 6000000) {
        world.move_to_next_event();
        const std::uint64_t now_us = world.time_us();
        if (const auto fix = gnss.measure(world)) {
            const std::uint64_t then_us = fix->timestamp_sample;
            EXPECT_EQ(fix->satellites == 0, then_us >= 2000000 && then_us < 4000000);
        }
        if (const auto frame = radio.measure(world)) {
            EXPECT_EQ(frame->is_heard, now_us < 1000000 || now_us >= 3000000);
        }
        if (baro.measure(world)) ++pressures;
        if (now_us < 2000000) {
            EXPECT_GT(world.battery().remaining(), 0.99);
        }
    }
    EXPECT_EQ(pressures, 250U);                   // of 300
    EXPECT_LE(world.battery().remaining(), 0.1);  // for good
}

TEST(World, a_glitch_pulls_the_fix_away_level) {
    Conditions conditions;
    World well{conditions, iris()};
    ASSERT_TRUE(conditions.faults.add({FaultKind::kGnssGlitch, 25.0, 0, 1000000}));
    World pulled{conditions, iris()};
    const GnssSimSample a = fixes(well, 1).front().second;
    const GnssSimSample b = fixes(pulled, 1).front().second;
    // 111.2 km are a degree of latitude here, 75.5 km one of longitude (WGS 84, to 0.1 %).
    const double north = (b.latitude_deg - a.latitude_deg) * 111170.0;
    const double east = (b.longitude_deg - a.longitude_deg) * 75500.0;
    EXPECT_NEAR(std::hypot(north, east), 25.0, 0.1);
    EXPECT_EQ(a.altitude_msl_m, b.altitude_msl_m);
}

TEST(World, a_broken_propeller_thrusts_less) {
    Conditions conditions;
    ASSERT_TRUE(conditions.faults.add({FaultKind::kPartial, 0.5, 0, 1000000, {"motor_1"}}));
    World world{conditions, iris()};
    world.move_to_next_event();
    world.command_motors(0, all(0.9F));
    run_until(world, 300000);
    // The front right one: the vehicle rolls right and pitches down.
    EXPECT_GT(world.plant().state().rate_B.x(), 0.5);
    EXPECT_LT(world.plant().state().rate_B.y(), -0.3);
}

TEST(World, motion_capture_arrives_late_with_the_time_of_its_picture) {
    World world{Conditions{}, iris()};
    MocapSimWorld mocap(world);
    std::vector<std::pair<std::uint64_t, std::uint64_t>> arrivals;
    while (world.next_event_us() <= 30000) {
        world.move_to_next_event();
        const auto seen = mocap.measure(world);
        if (seen) arrivals.emplace_back(world.time_us(), seen->timestamp_sample);
    }
    const decltype(arrivals) expected{{5000, 0}, {15000, 10000}, {25000, 20000}};
    EXPECT_EQ(arrivals, expected);
}

TEST(World, motion_capture_shows_where_the_vehicle_was_at_the_picture) {
    World world{Conditions{}, iris()};
    MocapSimWorld mocap(world);
    world.move_to_next_event();
    world.command_motors(0, all(1.0F));
    while (world.next_event_us() <= 504000) {
        world.move_to_next_event();
        static_cast<void>(mocap.measure(world));
    }
    const double z_then = [&] {
        World same{Conditions{}, iris()};
        same.move_to_next_event();
        same.command_motors(0, all(1.0F));
        run_until(same, 500000);
        return same.plant().state().position_N.z();
    }();
    world.move_to_next_event();
    const auto seen = mocap.measure(world);
    ASSERT_TRUE(seen);
    EXPECT_NEAR(static_cast<double>(seen->position_N[2]), z_then, 0.005);
    EXPECT_LT(world.plant().state().position_N.z(), z_then - 0.01);  // it has climbed since
}

TEST(World, command_acts_from_its_instant_on) {
    World world{Conditions{}, iris()};
    world.move_to_next_event();
    world.command_motors(300, all(1.0F));
    world.move_to_next_event();
    // A full battery without load has 12.31 V, where 11.877 V give 1100 rad/s.
    const double expected = 1100.0 * 12.308 / 11.877 * (1.0 - std::exp(-700e-6 / 0.0125));
    EXPECT_NEAR(world.plant().state().rotor_speeds[2], expected, 0.1);
}

TEST(World, flight_is_a_function_of_its_seed) {
    const auto end = [](std::uint64_t seed) {
        World world(Conditions{.seed = seed}, iris());
        ImuSimWorld imu(world);
        MagSimWorld mag(world);
        world.move_to_next_event();
        world.command_motors(0, all(0.6F));
        float sum = 0.0F;
        while (world.next_event_us() <= 200000) {
            world.move_to_next_event();
            const auto motion = imu.measure(world);
            sum += motion->gyro_B[0] + motion->accel_B[1];
            if (const auto field = mag.measure(world)) sum += field->field_B_gauss[2];
        }
        return sum;
    };
    EXPECT_EQ(end(5), end(5));
    EXPECT_NE(end(5), end(6));
}

TEST(World, sees_a_whole_flight) {
    World world{Conditions{}, iris()};
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
    World world{Conditions{}, iris()};
    world.move_to_next_event();
    world.command_motors(0, kStopped);
    run_until(world, 3000000);
    EXPECT_FALSE(world.is_over());
    EXPECT_FALSE(world.watch().take_off_us());
}

TEST(World, a_varied_vehicle_hears_its_commands_late) {
    const auto first_turn_us = [](std::uint64_t seed) {
        World world(Conditions{.seed = seed, .vary = true}, iris());
        world.move_to_next_event();
        world.command_motors(0, all(1.0F));
        while (world.plant().state().rotor_speeds[0] == 0.0) world.move_to_next_event();
        return world.plant().time_us();
    };
    const std::uint64_t delay_us = vary(iris(), Variation{}, 3).command_delay_us;
    EXPECT_GT(delay_us, 1000U);  // else this seed tells nothing
    EXPECT_EQ(first_turn_us(3), delay_us / 1000 * 1000 + 1000);
}

TEST(World, wind_acts_on_the_plant) {
    World world(Conditions{.wind = {.speed = 5.0, .from = 0.0}}, iris());
    world.move_to_next_event();
    EXPECT_NEAR((world.influence().wind_N - Vector3(-5.0, 0.0, 0.0)).norm(), 0.0, 1e-12);
    // Parts that measure at this event saw none of it yet.
    EXPECT_EQ(world.plant().influence().wind_N, Vector3(Vector3::Zero()));
    world.move_to_next_event();
    EXPECT_NEAR((world.plant().influence().wind_N - Vector3(-5.0, 0.0, 0.0)).norm(), 0.0, 1e-12);
}

TEST(Truth, names_its_columns_and_holds_the_state) {
    World world(Conditions{.wind = {.speed = 5.0, .from = 0.0}}, iris());
    run_until(world, 3000);
    std::FILE* const file = std::tmpfile();
    ASSERT_TRUE(write_truth_head(file, world));
    const long head = std::ftell(file);
    EXPECT_EQ(head % 8, 0);
    ASSERT_TRUE(write_truth(file, world));
    std::rewind(file);
    std::string line(static_cast<std::size_t>(head), ' ');
    EXPECT_EQ(std::fread(line.data(), 1, line.size(), file), line.size());
    EXPECT_EQ(line.substr(0, 42), "time_us position_n position_e position_d v");
    EXPECT_EQ(line.back(), '\n');
    std::vector<std::string> names;
    std::istringstream words(line);
    for (std::string name; words >> name;) names.push_back(name);
    EXPECT_EQ(names.size(), 25U);
    std::vector<double> row(names.size() + 1);
    EXPECT_EQ(std::fread(row.data(), sizeof(double), row.size(), file), names.size());
    const auto column = [&](const std::string& name) {
        const auto found = std::find(names.begin(), names.end(), name);
        return row[static_cast<std::size_t>(found - names.begin())];
    };
    const VehicleState& state = world.plant().state();
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
}  // namespace stator::world
