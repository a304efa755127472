// The simulated sensors against their data sheets' figures.
#include "world/sensors.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <vector>

#include "iris.hpp"

namespace stator::world {
namespace {

struct Statistics {
    Vector3 mean = Vector3::Zero();
    Vector3 deviation = Vector3::Zero();
};

Statistics statistics(const std::vector<Vector3f>& samples) {
    Statistics result;
    for (const Vector3f& sample : samples) result.mean += sample.cast<double>();
    result.mean /= static_cast<double>(samples.size());
    for (const Vector3f& sample : samples) {
        result.deviation += (sample.cast<double>() - result.mean).cwiseAbs2();
    }
    result.deviation /= static_cast<double>(samples.size());
    result.deviation = result.deviation.cwiseSqrt();
    return result;
}

constexpr unsigned kSamples = 20000;

struct Recording {
    std::vector<Vector3f> gyro;
    std::vector<Vector3f> accel;
};

Recording record(const ImuParameters& parameters, const Plant& plant, std::uint64_t seed) {
    Imu imu(parameters, 4, seed);
    Recording result;
    for (unsigned i = 0; i < kSamples; ++i) {
        const ImuSample sample = imu.measure(plant);
        result.gyro.push_back(sample.gyro_B);
        result.accel.push_back(sample.accel_B);
    }
    return result;
}

Plant at_rest() {
    return {iris().airframe, VehicleState{}};
}

Plant hovering() {
    VehicleState state;
    state.position_N.z() = -10.0;
    state.rotor_speeds.setConstant(802.746);
    return {iris().airframe, state};
}

TEST(Imu, noise_at_rest_is_that_of_the_data_sheet) {
    const Recording recording = record(ImuParameters{}, at_rest(), 1);
    const Statistics gyro = statistics(recording.gyro);
    const Statistics accel = statistics(recording.accel);
    for (int axis = 0; axis < 3; ++axis) {
        // 0.005 deg/s and 400 ug per sqrt(Hz) up to 500 Hz; 20,000 samples know it to 0.5 %.
        EXPECT_NEAR(gyro.deviation[axis], 0.005 * M_PI / 180.0 * std::sqrt(500.0), 5e-5);
        EXPECT_NEAR(accel.deviation[axis], 400e-6 * 9.80665 * std::sqrt(500.0), 2e-3);
    }
}

TEST(Imu, feels_weight_at_rest_upwards) {
    const Statistics accel = statistics(record(ImuParameters{}, at_rest(), 1).accel);
    EXPECT_NEAR(accel.mean.x(), 0.0, 4.0 * 0.02);
    EXPECT_NEAR(accel.mean.z(), -9.80665, 4.0 * 0.02);
}

// Allan variance of a series at an averaging time of `length` samples (IEEE Std 952).
double allan_variance(const std::vector<double>& series, std::size_t length) {
    std::vector<double> means;
    for (std::size_t i = 0; i + length <= series.size(); i += length) {
        double sum = 0.0;
        for (std::size_t k = 0; k < length; ++k) sum += series[i + k];
        means.push_back(sum / static_cast<double>(length));
    }
    double sum = 0.0;
    for (std::size_t i = 1; i < means.size(); ++i) sum += std::pow(means[i] - means[i - 1], 2);
    return 0.5 * sum / static_cast<double>(means.size() - 1);
}

TEST(Imu, angle_random_walk_is_that_of_the_noise_density) {
    Imu imu(ImuParameters{}, 4, 1);
    const Plant plant = at_rest();
    std::vector<double> gyro;
    std::vector<double> accel;
    for (int i = 0; i < 400000; ++i) {
        const ImuSample sample = imu.measure(plant);
        gyro.push_back(static_cast<double>(sample.gyro_B.y()));
        accel.push_back(static_cast<double>(sample.accel_B.x()));
    }
    // White noise of one-sided density d: d^2 / (2 tau). 400 s know it to 3 % at 0.1 s.
    for (const std::size_t length : {10U, 100U}) {
        const double tau = 1e-3 * static_cast<double>(length);
        EXPECT_NEAR(std::sqrt(allan_variance(gyro, length) * 2.0 * tau) / (0.005 * M_PI / 180.0),
                    1.0, 0.06);
        EXPECT_NEAR(std::sqrt(allan_variance(accel, length) * 2.0 * tau) / (400e-6 * 9.80665), 1.0,
                    0.06);
    }
}

// An IMU without noise, biases and drift, fine enough to see one of them alone near zero.
ImuParameters still() {
    ImuParameters parameters;
    parameters.gyro_noise = 0.0F;
    parameters.gyro_bias = 0.0F;
    parameters.gyro_per_degc = 0.0;
    parameters.gyro_instability = 0.0;
    parameters.gyro_steps = 1e6F;
    return parameters;
}

TEST(Imu, bias_wanders_as_a_gauss_markov_process) {
    ImuParameters parameters = still();
    parameters.gyro_instability = 5.6e-5;
    parameters.period_us = 100000;  // no faster than it wanders
    parameters.drift_samples = 1;
    Imu imu(parameters, 4, 1);
    const Plant plant = at_rest();
    std::array<std::vector<double>, 3> gyro;  // 20,000 s
    for (int i = 0; i < 200000; ++i) {
        const ImuSample sample = imu.measure(plant);
        for (int axis = 0; axis < 3; ++axis) {
            gyro[static_cast<std::size_t>(axis)].push_back(
                static_cast<double>(sample.gyro_B[axis]));
        }
    }
    // IEEE Std 952, C.1.4: 2 s^2 T / t (1 - T / 2t (3 - 4 exp(-t / T) + exp(-2 t / T))).
    for (const double t : {10.0, 100.0}) {
        const double e = std::exp(-t / 100.0);
        const double theory =
            2.0 * 5.6e-5 * 5.6e-5 * 100.0 / t * (1.0 - 50.0 / t * (3.0 - 4.0 * e + e * e));
        double found = 0.0;
        for (const auto& axis : gyro)
            found += allan_variance(axis, static_cast<std::size_t>(10 * t));
        // 600 means of 100 s know their variance to 7 %.
        EXPECT_NEAR(found / 3.0 / theory, 1.0, t < 50.0 ? 0.08 : 0.2) << t;
    }
}

TEST(Imu, warms_and_drifts) {
    ImuParameters parameters = still();
    parameters.gyro_per_degc = 0.00093;
    parameters.warming_tau = 0.05;
    const Plant plant = at_rest();
    std::vector<Vector3f> gyro;
    for (std::uint64_t seed = 0; seed < 400; ++seed) {
        Imu imu(parameters, 4, seed);
        EXPECT_EQ(imu.measure(plant).gyro_B, Vector3f::Zero());
        for (int i = 0; i < 999; ++i) imu.measure(plant);
        gyro.push_back(imu.measure(plant).gyro_B);
    }
    // A third of 0.16 deg/s for each of 2 degC.
    for (int axis = 0; axis < 3; ++axis) {
        EXPECT_NEAR(statistics(gyro).deviation[axis], 0.32 / 3.0 * M_PI / 180.0, 2.5e-4);
    }
}

TEST(Imu, bias_differs_from_seed_to_seed_by_its_deviation) {
    std::vector<Vector3f> gyro;
    std::vector<Vector3f> accel;
    ImuParameters silent;
    silent.gyro_noise = 0.0F;
    silent.accel_noise = 0.0F;
    const Plant plant = at_rest();
    for (std::uint64_t seed = 0; seed < 400; ++seed) {
        const ImuSample sample = Imu(silent, 4, seed).measure(plant);
        gyro.push_back(sample.gyro_B);
        accel.push_back(sample.accel_B);
    }
    for (int axis = 0; axis < 3; ++axis) {
        EXPECT_NEAR(statistics(gyro).deviation[axis], 0.01, 0.0015);
        EXPECT_NEAR(statistics(accel).deviation[axis], 1.7e-3 * 9.80665, 2.5e-3);
    }
}

TEST(Imu, shakes_in_flight_and_still_means_the_truth) {
    const Statistics gyro = statistics(record(ImuParameters{}, hovering(), 1).gyro);
    const Statistics rest = statistics(record(ImuParameters{}, at_rest(), 1).gyro);
    for (int axis = 0; axis < 3; ++axis) {
        // Flight records: 10 to 50 times the data sheet's noise.
        EXPECT_GT(gyro.deviation[axis], 10.0 * rest.deviation[axis]);
        EXPECT_LT(gyro.deviation[axis], 50.0 * rest.deviation[axis]);
        EXPECT_NEAR(gyro.mean[axis], rest.mean[axis], 2e-3);
    }
}

// Power of one component at a frequency, by Fourier's sum.
double power(const std::vector<Vector3f>& samples, double frequency_hz) {
    double real = 0.0;
    double imaginary = 0.0;
    for (std::size_t i = 0; i < samples.size(); ++i) {
        const double angle = 2.0 * M_PI * frequency_hz * static_cast<double>(i) * 1e-3;
        real += static_cast<double>(samples[i].x()) * std::cos(angle);
        imaginary += static_cast<double>(samples[i].x()) * std::sin(angle);
    }
    return real * real + imaginary * imaginary;
}

TEST(Imu, vibration_has_a_line_at_the_rotors_frequency) {
    const Recording recording = record(ImuParameters{}, hovering(), 1);
    const double rotor_hz = 802.746 / (2.0 * M_PI);
    EXPECT_GT(power(recording.gyro, rotor_hz), 100.0 * power(recording.gyro, rotor_hz + 20.0));
    EXPECT_GT(power(recording.accel, rotor_hz), 100.0 * power(recording.accel, rotor_hz + 20.0));
}

TEST(Imu, saturates_at_its_range) {
    VehicleState state;
    state.position_N.z() = -10.0;
    state.rate_B = Vector3(100.0, -100.0, 0.0);
    const ImuSample sample = Imu(ImuParameters{}, 4, 1).measure(Plant(iris().airframe, state));
    EXPECT_NEAR(sample.gyro_B.x(), 2000.0 * M_PI / 180.0, 0.05);
    EXPECT_NEAR(sample.gyro_B.y(), -2000.0 * M_PI / 180.0, 0.05);
}

TEST(Mocap, sees_position_and_heading_to_the_millimetre) {
    VehicleState state;
    state.position_N = Vector3(1.0, -2.0, -3.0);
    state.q_NB = math::from_euler(math::EulerAngles<double>{0.3, -0.2, 2.0});
    const Plant plant(iris().airframe, state);
    Mocap mocap(MocapParameters{}, 1);
    std::vector<Vector3f> positions;
    std::vector<Vector3f> yaws;
    for (unsigned i = 0; i < kSamples; ++i) {
        const MocapSample sample = mocap.measure(plant);
        positions.push_back(sample.position_N);
        yaws.emplace_back(sample.yaw, 0.0F, 0.0F);
    }
    const Statistics position = statistics(positions);
    EXPECT_NEAR((position.mean - state.position_N).norm(), 0.0, 5e-5);
    EXPECT_NEAR(position.deviation.y(), 0.001, 5e-5);
    EXPECT_NEAR(statistics(yaws).mean.x(), 2.0, 2e-4);
    EXPECT_NEAR(statistics(yaws).deviation.x(), 0.2 * M_PI / 180.0, 1e-4);
}

TEST(Mocap, heading_stays_within_half_a_turn) {
    VehicleState state;
    state.q_NB = math::from_euler(math::EulerAngles<double>{0.0, 0.0, M_PI});
    const Plant plant(iris().airframe, state);
    Mocap mocap(MocapParameters{}, 1);
    bool east_of_south = false;
    bool west_of_south = false;
    for (int i = 0; i < 100; ++i) {
        const float yaw = mocap.measure(plant).yaw;
        EXPECT_LE(std::abs(yaw), math::kPi<float>);
        east_of_south |= yaw > 3.0F;
        west_of_south |= yaw < -3.0F;
    }
    EXPECT_TRUE(east_of_south && west_of_south);
}

}  // namespace
}  // namespace stator::world
