// The simulated wind against MIL-F-8785C and Dryden's spectra.
#include "world/wind.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <vector>

namespace stator::world {
namespace {

TEST(GustScale, is_that_of_the_specification) {
    // 50 m is 164.04 ft: base 0.177 + 0.000823 * 164.04 = 0.31200, W20 30 kt = 15.433 m/s.
    const GustScale moderate = gust_scale(Gusts::kModerate, 50.0);
    EXPECT_NEAR(moderate.vertical, 50.0, 1e-9);
    EXPECT_NEAR(moderate.level, 50.0 / std::pow(0.31200, 1.2), 0.01);
    EXPECT_NEAR(moderate.sigma_vertical, 1.5433, 1e-4);
    EXPECT_NEAR(moderate.sigma_level, 1.5433 / std::pow(0.31200, 0.4), 1e-4);
    // At 1000 ft the specification's level and vertical scales meet, and so do the intensities.
    const GustScale high = gust_scale(Gusts::kLight, 304.8);
    EXPECT_NEAR(high.level, 304.8, 0.1);
    EXPECT_NEAR(high.sigma_level, high.sigma_vertical, 1e-3);
    EXPECT_NEAR(high.sigma_vertical, 0.7717, 1e-4);  // 15 kt
    // Nothing changes beyond its ends.
    EXPECT_EQ(gust_scale(Gusts::kSevere, 0.0).vertical, gust_scale(Gusts::kSevere, 3.0).vertical);
    EXPECT_EQ(gust_scale(Gusts::kNone, 50.0).sigma_level, 0.0);
}

// The one-sided spectrum at `frequency` rad/s, averaged over pieces of a series of period 1; a
// Hann window keeps what is strong elsewhere away.
double spectrum(const std::function<double()>& next, double frequency, double period) {
    constexpr unsigned kPieces = 400;
    constexpr unsigned kLength = 2000;
    double sum = 0.0;
    for (unsigned piece = 0; piece < kPieces; ++piece) {
        double real = 0.0;
        double imaginary = 0.0;
        for (unsigned i = 0; i < kLength; ++i) {
            const double window = 1.0 - std::cos(2.0 * M_PI * i / kLength);
            const double value = window * next();
            real += value * std::cos(frequency * period * i);
            imaginary += value * std::sin(frequency * period * i);
        }
        sum += real * real + imaginary * imaginary;
    }
    // The window's mean square is 1.5; over pi, as the spectrum is one-sided by rad/s.
    return sum / kPieces * period / (1.5 * kLength) / M_PI;
}

// Of unit variance, T = 1 s: Dryden's spectra, MIL-F-8785C 3.7.2.
double longitudinal(double w) {
    return 2.0 / M_PI / (1.0 + w * w);
}
double transverse(double w) {
    return 1.0 / M_PI * (1.0 + 3.0 * w * w) / std::pow(1.0 + w * w, 2);
}

template <class Gust>
void has_spectrum(double (*theory)(double)) {
    math::Random random(1);
    for (const double step : {0.02, 0.1}) {
        Gust gust;
        for (int i = 0; i < 5000; ++i) gust.next(step, random);
        for (const double frequency : {0.6, 1.5, 4.0}) {
            const double found = spectrum([&] { return gust.next(step, random); }, frequency, step);
            // 400 pieces know it to 5 %; three of these. What folds back at step 0.1 is 2 %.
            EXPECT_NEAR(found / theory(frequency), 1.0, 0.17) << step << ", " << frequency;
        }
    }
}

TEST(LongitudinalGust, has_drydens_spectrum) {
    has_spectrum<LongitudinalGust>(longitudinal);
}

TEST(TransverseGust, has_drydens_spectrum) {
    has_spectrum<TransverseGust>(transverse);
}

// Variance and correlation of neighbours over a long run.
template <class Gust>
std::pair<double, double> statistics(double step) {
    math::Random random(2);
    Gust gust;
    for (int i = 0; i < 100; ++i) gust.next(1.0, random);
    double squares = 0.0;
    double products = 0.0;
    double before = gust.next(step, random);
    constexpr int kSamples = 400000;
    for (int i = 0; i < kSamples; ++i) {
        const double now = gust.next(step, random);
        squares += now * now;
        products += now * before;
        before = now;
    }
    return {squares / kSamples, products / kSamples};
}

TEST(LongitudinalGust, has_unit_variance_at_any_step) {
    for (const double step : {0.2, 1.0, 3.0}) {
        const auto [variance, correlation] = statistics<LongitudinalGust>(step);
        EXPECT_NEAR(variance, 1.0, 0.02);
        EXPECT_NEAR(correlation, std::exp(-step), 0.02);
    }
}

TEST(TransverseGust, has_unit_variance_at_any_step) {
    for (const double step : {0.2, 1.0, 3.0}) {
        const auto [variance, correlation] = statistics<TransverseGust>(step);
        EXPECT_NEAR(variance, 1.0, 0.02);
        // Of the spectrum above: exp(-t) (1 - t / 2).
        EXPECT_NEAR(correlation, std::exp(-step) * (1.0 - 0.5 * step), 0.02);
    }
}

TEST(Wind, is_its_mean_without_gusts) {
    Wind wind({.speed = 8.0, .from = 1.5 * M_PI}, 1);
    EXPECT_NEAR((wind.at(0, 10.0, 8.0) - Vector3(0.0, 8.0, 0.0)).norm(), 0.0, 1e-12);
}

TEST(Wind, gusts_have_the_intensity_of_their_height_over_many_seeds) {
    Vector3 squares = Vector3::Zero();
    constexpr unsigned kSeeds = 4000;
    for (unsigned seed = 0; seed < kSeeds; ++seed) {
        constexpr double kFrom = 0.7;
        Wind wind({.speed = 8.0, .from = kFrom, .gusts = Gusts::kModerate}, seed);
        wind.at(0, 10.0, 8.0);
        const Vector3 along_N(-std::cos(kFrom), -std::sin(kFrom), 0.0);
        const Vector3 gust_N = wind.at(10000, 10.0, 8.0) - 8.0 * along_N;
        const Vector3 across_N = Vector3::UnitZ().cross(along_N);
        squares += Vector3(gust_N.dot(along_N), gust_N.dot(across_N), gust_N.z()).cwiseAbs2();
    }
    const GustScale scale = gust_scale(Gusts::kModerate, 10.0);
    const Vector3 sigma = (squares / kSeeds).cwiseSqrt();
    // 4000 draws know it to 1.1 %.
    EXPECT_NEAR(sigma.x() / scale.sigma_level, 1.0, 0.04);
    EXPECT_NEAR(sigma.y() / scale.sigma_level, 1.0, 0.04);
    EXPECT_NEAR(sigma.z() / scale.sigma_vertical, 1.0, 0.04);
}

TEST(Wind, changes_steadily) {
    Wind wind({.speed = 0.0, .from = 0.0, .gusts = Gusts::kSevere}, 1);
    Vector3 before = wind.at(0, 3.0, 3.0);
    double most = 0.0;
    for (std::uint64_t time_us = 1000; time_us <= 5000000; time_us += 1000) {
        const Vector3 now = wind.at(time_us, 3.0, 3.0);
        most = std::max(most, (now - before).norm());
        before = now;
    }
    // A tenth of what 10 ms bring, sigma sqrt(3 * 10 ms / T): 0.04 m/s down (sigma 2.3 m/s, T 1 s),
    // 0.03 m/s each way level (4.5 m/s, 7.7 s); the largest of 500 is five to six times that.
    EXPECT_LT(most, 0.4);
    EXPECT_GT(most, 0.02);
}

}  // namespace
}  // namespace stator::world
