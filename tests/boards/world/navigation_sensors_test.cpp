// Magnetometer, barometer and satellite receiver against figures from elsewhere.
#include "world/navigation_sensors.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "iris.hpp"
#include "world/battery.hpp"
#include "world/variation.hpp"

namespace stator::world {
namespace {

constexpr double kDegrees = M_PI / 180.0;

double deviation(const std::vector<double>& values) {
    double mean = 0.0;
    for (const double value : values) mean += value / static_cast<double>(values.size());
    double squares = 0.0;
    for (const double value : values) squares += std::pow(value - mean, 2);
    return std::sqrt(squares / static_cast<double>(values.size()));
}

VehicleState at(const Vector3& position_N) {
    VehicleState state;
    state.position_N = position_N;
    return state;
}

TEST(GaussMarkov, keeps_its_variance_at_any_period) {
    for (const double period : {0.1, 2.0}) {
        math::Random random(1);
        GaussMarkov noise(Vector3(0.5, 1.0, 2.0), 1.0, period, random);
        std::vector<double> values;
        double products = 0.0;
        for (int i = 0; i < 100000; ++i) {
            const double before = noise.value().z();
            values.push_back(noise.next(random).z());
            products += before * values.back() / 100000.0;
        }
        EXPECT_NEAR(deviation(values), 2.0, 0.06);
        EXPECT_NEAR(products / 4.0, std::exp(-period), 0.03);
    }
}

TEST(Earth, a_step_is_as_long_as_the_ellipsoid_says) {
    const Earth earth;
    const Geodetic home = earth.geodetic(Vector3::Zero());
    EXPECT_EQ(home.latitude_deg, 47.397742);
    EXPECT_EQ(home.altitude_msl, 488.0);
    EXPECT_EQ(home.altitude_ellipsoid, 535.6);
    // Series for the length of a degree of WGS 84 at latitude f, in m (NIMA TR8350.2's ellipsoid):
    // 111132.954 - 559.822 cos 2f + 1.175 cos 4f, 111412.84 cos f - 93.5 cos 3f + 0.118 cos 5f.
    const double f = 47.397742 * kDegrees;
    const double above = 1.0 + 535.6 / 6.37e6;
    const double north = above * (111132.954 - 559.822 * std::cos(2 * f) + 1.175 * std::cos(4 * f));
    const double east =
        above * (111412.84 * std::cos(f) - 93.5 * std::cos(3 * f) + 0.118 * std::cos(5 * f));
    const Geodetic there = earth.geodetic(Vector3(300.0, -400.0, -50.0));
    EXPECT_NEAR((there.latitude_deg - home.latitude_deg) * north, 300.0, 2e-3);
    EXPECT_NEAR((there.longitude_deg - home.longitude_deg) * east, -400.0, 2e-3);
    EXPECT_EQ(there.altitude_msl, 538.0);
}

TEST(Earth, has_the_standard_atmosphere) {
    Earth earth;
    earth.altitude_msl = 0.0;
    // Tables of ISO 2533: 500 m, 1000 m.
    EXPECT_NEAR(earth.pressure(0.0), 101325.0, 1e-6);
    EXPECT_NEAR(earth.pressure(500.0), 95461.0, 1.0);
    EXPECT_NEAR(earth.pressure(1000.0), 89876.0, 2.0);
    EXPECT_NEAR(earth.temperature_degc(1000.0), 8.5, 1e-9);
}

TEST(Magnetometer, sees_declination_and_inclination) {
    MagnetometerParameters parameters;
    parameters.hard_iron = 0.0;
    Magnetometer magnetometer(parameters, Earth{}, 1);
    VehicleState state;
    state.q_NB = math::from_euler(math::EulerAngles<double>{0.0, 0.0, 1.0});
    Vector3 sum = Vector3::Zero();
    std::vector<double> down;
    for (int i = 0; i < 10000; ++i) {
        const Vector3 field_B = magnetometer.measure(state, 0.0).cast<double>();
        sum += field_B;
        down.push_back(field_B.z());
    }
    const Vector3 field_B = sum / 10000.0;
    EXPECT_NEAR(field_B.norm(), 0.484, 1e-4);
    EXPECT_NEAR(std::atan2(field_B.y(), field_B.x()) + 1.0, 3.3 * kDegrees, 1e-3);
    EXPECT_NEAR(std::asin(field_B.z() / field_B.norm()), 63.4 * kDegrees, 1e-3);
    EXPECT_NEAR(deviation(down), 0.002, 1e-4);
}

TEST(Magnetometer, is_pulled_by_iron_and_current) {
    MagnetometerParameters parameters;
    parameters.noise = 0.0;
    std::vector<double> iron;
    for (std::uint64_t seed = 0; seed < 1000; ++seed) {
        Magnetometer magnetometer(parameters, Earth{}, seed);
        const Vector3 idle = magnetometer.measure(VehicleState{}, 0.0).cast<double>();
        const Vector3 loaded = magnetometer.measure(VehicleState{}, 50.0).cast<double>();
        iron.push_back(idle.x());
        EXPECT_NEAR((loaded - idle).norm(), 0.01, 2e-3);  // 0.2 mG/A; a step is 0.9 mG
    }
    EXPECT_NEAR(deviation(iron), 0.010, 0.001);
}

TEST(Barometer, measures_pressure_with_noise_and_an_offset) {
    BarometerParameters parameters;
    parameters.drift = 0.0;
    std::vector<double> offsets;
    const Plant plant(iris().airframe, at(Vector3(0.0, 0.0, -100.0)));
    for (std::uint64_t seed = 0; seed < 400; ++seed) {
        Barometer barometer(parameters, Earth{}, seed);
        offsets.push_back(static_cast<double>(barometer.measure(plant).pressure));
    }
    EXPECT_NEAR(deviation(offsets), 50.0, 6.0);
    parameters.offset = 0.0;
    Barometer barometer(parameters, Earth{}, 1);
    std::vector<double> samples;
    double mean = 0.0;
    for (int i = 0; i < 10000; ++i) {
        samples.push_back(static_cast<double>(barometer.measure(plant).pressure));
        mean += samples.back() / 10000.0;
    }
    // ISO 2533 by hand: 101325 (1 - 0.0065 * 588 / 288.15)^5.25588.
    EXPECT_NEAR(mean, 94457.8, 0.5);
    EXPECT_NEAR(deviation(samples), std::sqrt(1.2 * 1.2 + 1.0 / 12.0), 0.03);  // and its steps
}

TEST(Barometer, feels_wind_and_rotors_and_drifts) {
    BarometerParameters parameters;
    parameters.noise = parameters.offset = parameters.drift = 0.0;
    VehicleState state = at(Vector3(0.0, 0.0, -100.0));
    const auto pressure = [&](const Plant& plant) {
        return static_cast<double>(Barometer(parameters, Earth{}, 1).measure(plant).pressure);
    };
    Plant plant(iris().airframe, state);
    const double calm = pressure(plant);
    plant.set_influence({.wind_N = Vector3(20.0, 0.0, 0.0)});
    EXPECT_NEAR(pressure(plant) - calm, -0.1 * 0.5 * 1.225 * 400.0, 1.0);
    state.rotor_speeds.setConstant(802.746);
    EXPECT_NEAR(pressure(Plant(iris().airframe, state)) - calm, 5.0, 1.0);
    parameters.drift = 15.0;
    std::vector<double> drifted;
    parameters.period_us = 1000000;
    Barometer barometer(parameters, Earth{}, 1);
    for (int i = 0; i < 60000; ++i) {  // 100 time constants
        drifted.push_back(static_cast<double>(barometer.measure(plant).pressure));
    }
    EXPECT_NEAR(deviation(drifted), 15.0, 3.5);
}

TEST(GnssReceiver, errs_by_a_slow_and_a_fast_part) {
    const Earth earth;
    const Plant plant(iris().airframe, at(Vector3(0.0, 0.0, -20.0)));
    std::vector<double> north;    // of the first fix of each seed
    std::vector<double> changed;  // a minute later
    std::vector<double> velocity;
    for (std::uint64_t seed = 0; seed < 1000; ++seed) {
        GnssReceiver receiver(GnssParameters{}, earth, seed);
        const auto place = [&] {
            return 111170.0 * (receiver.measure(plant, {}).fix.place.latitude_deg - 47.397742);
        };
        north.push_back(place());
        for (int i = 0; i < 299; ++i) receiver.measure(plant, {});
        changed.push_back(place() - north.back());
        velocity.push_back(static_cast<double>(receiver.measure(plant, {}).fix.velocity_N.z()));
    }
    EXPECT_NEAR(deviation(north), std::sqrt(1.2 * 1.2 + 0.15 * 0.15), 0.08);
    // The slow part: 2 sigma^2 (1 - exp(-60 / 1100)); the fast one has forgotten all.
    const double slow = 2.0 * 1.44 * (1.0 - std::exp(-60.0 / 1100.0));
    EXPECT_NEAR(deviation(changed), std::sqrt(slow + 2.0 * 0.15 * 0.15), 0.04);
    EXPECT_NEAR(deviation(velocity), 0.10, 0.007);
}

TEST(Battery, gives_the_cells_voltage_less_what_its_resistance_takes) {
    // The formula of Chen and Rincon-Mora by calculator, at 1, 1/2 and 0.
    EXPECT_NEAR(open_circuit_voltage(1.0), 4.1029, 1e-4);
    EXPECT_NEAR(open_circuit_voltage(0.5), 3.8034, 1e-4);
    EXPECT_NEAR(open_circuit_voltage(0.0), 2.654, 1e-4);
    Battery battery(iris().battery);
    battery.draw(170.8, 0.0);
    EXPECT_NEAR(battery.voltage(), 11.877, 1e-3);  // see Airframe::nominal_voltage
    EXPECT_NEAR(battery.voltage() * battery.current(), 170.8, 1e-6);
}

TEST(Battery, lasts_as_long_as_its_charge) {
    Battery battery(iris().battery);
    double seconds = 0.0;
    for (; battery.remaining() > 0.2; seconds += 0.1) battery.draw(170.8, 0.1);
    // The Iris flies 16 to 22 minutes by its makers; 80 % of 5.1 Ah at 15 A are 16.
    EXPECT_NEAR(seconds / 60.0, 16.0, 1.0);
    EXPECT_NEAR(battery.discharged_c(), 0.8 * 5.1 * 3600.0, 10.0);
    for (int i = 0; i < 10000; ++i) battery.draw(1e5, 0.1);  // more than there is
    EXPECT_EQ(battery.remaining(), 0.0);
    EXPECT_GT(battery.voltage(), 0.0);
}

TEST(Battery, a_limit_is_for_good) {
    Battery battery(iris().battery);
    battery.limit(0.3);
    battery.limit(0.9);
    EXPECT_EQ(battery.remaining(), 0.3);
}

TEST(Variation, stays_within_its_limits_and_reaches_for_them) {
    const Airframe usual = iris().airframe;
    double most_mass = 0.0;
    double least_delay = 1e9;
    for (std::uint64_t seed = 0; seed < 500; ++seed) {
        const Vehicle vehicle = vary(iris(), Variation{}, seed);
        const double mass = vehicle.airframe.mass / usual.mass - 1.0;
        EXPECT_LE(std::abs(mass), 0.15);
        most_mass = std::max(most_mass, mass);
        for (int axis = 0; axis < 3; ++axis) {
            Vector3 turn = Vector3::Zero();
            turn[axis] = 1.0;
            const Vector3 moment = vehicle.airframe.inertia.times(turn);
            EXPECT_NEAR(moment[axis] / usual.inertia.times(turn)[axis], 1.0, 0.2);
        }
        EXPECT_NEAR(vehicle.airframe.thrust_per_speed2 / usual.thrust_per_speed2, 1.0, 0.1);
        EXPECT_NEAR(vehicle.airframe.rotors[0].place_B.x(), usual.rotors[0].place_B.x(), 0.01);
        // Arms and feet move together, and keep their distances.
        EXPECT_NEAR(vehicle.airframe.rotors[0].place_B.y() - vehicle.airframe.rotors[1].place_B.y(),
                    0.42, 1e-12);
        EXPECT_NEAR(
            vehicle.airframe.ground.points_B[0].x() - vehicle.airframe.rotors[0].place_B.x(), 0.0,
            1e-12);
        EXPECT_LE(vehicle.command_delay_us, 6000U);
        least_delay = std::min(least_delay, static_cast<double>(vehicle.command_delay_us));
    }
    EXPECT_GT(most_mass, 0.14);
    EXPECT_LT(least_delay, 300.0);
}

}  // namespace
}  // namespace stator::world
