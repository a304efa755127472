// The generator against its authors' known answers, and its distributions against theory. The seeds
// are fixed, so each result is the same for ever; each limit is one that a right generator passes
// with all but one seed in thousands.
#include "stator/random.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace stator::math {
namespace {

using Words = std::array<std::uint32_t, 4>;

// Answers: kat_vectors of Random123, the reference implementation by the paper's authors.
TEST(Philox, KnownAnswers) {
    EXPECT_EQ(philox_4x32_10({0, 0, 0, 0}, {0, 0}),
              (Words{0x6627e8d5, 0xe169c58d, 0xbc57ac4c, 0x9b00dbd8}));
    EXPECT_EQ(
        philox_4x32_10({0xffffffff, 0xffffffff, 0xffffffff, 0xffffffff}, {0xffffffff, 0xffffffff}),
        (Words{0x408f276d, 0x41c83b0e, 0xa20bc7c6, 0x6d5451fd}));
    // Digits of pi.
    EXPECT_EQ(
        philox_4x32_10({0x243f6a88, 0x85a308d3, 0x13198a2e, 0x03707344}, {0xa4093822, 0x299f31d0}),
        (Words{0xd16cfe09, 0x94fdcceb, 0x5001e420, 0x24126ea1}));
}

TEST(Random, WordsAreTheBlocksInOrder) {
    Random random(0x0123456789abcdef, 0xfedcba9876543210);
    for (std::uint32_t block = 0; block < 3; ++block) {
        for (const std::uint32_t expected :
             philox_4x32_10({block, 0, 0x76543210, 0xfedcba98}, {0x89abcdef, 0x01234567})) {
            EXPECT_EQ(random.word(), expected);
        }
    }
}

TEST(Random, ACopyContinuesAndASplitStartsAnew) {
    Random random(7, 1);
    random.word();
    Random copy = random;
    EXPECT_EQ(copy.word(), random.word());
    Random split = random.split(2);
    Random fresh(7, 2);
    EXPECT_EQ(split.word(), fresh.word());
}

TEST(Random, StreamsAndSeedsAreUnrelated) {
    Random reference(7, 1);
    Random other_stream(7, 2);
    Random other_seed(8, 1);
    constexpr int kCount = 100000;
    int same_bits_stream = 0;
    int same_bits_seed = 0;
    for (int i = 0; i < kCount; ++i) {
        const std::uint32_t word = reference.word();
        same_bits_stream += std::popcount(word ^ other_stream.word());
        same_bits_seed += std::popcount(word ^ other_seed.word());
    }
    // Binomial: mean 16 of 32 bits, standard deviation sqrt(32 n / 4); 4 of them.
    const double limit = 4.0 * std::sqrt(8.0 * kCount);
    EXPECT_NEAR(same_bits_stream, 16.0 * kCount, limit);
    EXPECT_NEAR(same_bits_seed, 16.0 * kCount, limit);
}

// Largest distance between the sample's distribution and `cdf`, times sqrt(n).
template <typename Cdf>
double kolmogorov(std::vector<double> sample, Cdf cdf) {
    std::sort(sample.begin(), sample.end());
    const auto n = static_cast<double>(sample.size());
    double largest = 0.0;
    for (std::size_t i = 0; i < sample.size(); ++i) {
        const double p = cdf(sample[i]);
        const auto below = static_cast<double>(i);
        largest = std::max({largest, p - below / n, (below + 1.0) / n - p});
    }
    return largest * std::sqrt(n);
}

// Exceeded with a chance of 1 in 3,000 (2 exp(-2 t^2), Kolmogorov 1933).
constexpr double kKolmogorovLimit = 2.1;
constexpr int kCount = 400000;

template <typename Draw>
std::vector<double> draw(Draw one) {
    std::vector<double> sample;
    sample.reserve(kCount);
    for (int i = 0; i < kCount; ++i) sample.push_back(static_cast<double>(one()));
    return sample;
}

TEST(Random, UniformIsUniform) {
    Random random(11);
    const auto identity = [](double x) { return x; };
    const auto floats = draw([&] { return random.uniform_float(); });
    EXPECT_LT(kolmogorov(floats, identity), kKolmogorovLimit);
    EXPECT_GE(*std::min_element(floats.begin(), floats.end()), 0.0);
    EXPECT_LT(*std::max_element(floats.begin(), floats.end()), 1.0);
    const auto doubles = draw([&] { return random.uniform_double(); });
    EXPECT_LT(kolmogorov(doubles, identity), kKolmogorovLimit);
    EXPECT_LT(*std::max_element(doubles.begin(), doubles.end()), 1.0);
}

void expect_normal(const std::vector<double>& sample) {
    EXPECT_LT(kolmogorov(sample, [](double x) { return 0.5 * std::erfc(-x / std::sqrt(2.0)); }),
              kKolmogorovLimit);
    const auto n = static_cast<double>(sample.size());
    std::array<double, 5> moment{};
    for (const double x : sample) {
        double power = 1.0;
        for (double& sum : moment) {
            sum += power / n;
            power *= x;
        }
    }
    // Expected 0, 1, 0, 3; the standard deviation of the mean of x^k is sqrt(E x^2k - (E x^k)^2)/n,
    // with E x^6 = 15 and E x^8 = 105; 4 of them.
    EXPECT_NEAR(moment[1], 0.0, 4.0 * std::sqrt(1.0 / n));
    EXPECT_NEAR(moment[2], 1.0, 4.0 * std::sqrt(2.0 / n));
    EXPECT_NEAR(moment[3], 0.0, 4.0 * std::sqrt(15.0 / n));
    EXPECT_NEAR(moment[4], 3.0, 4.0 * std::sqrt(96.0 / n));
    for (const double sigmas : {2.0, 3.0, 4.0}) {
        const double expected = n * std::erfc(sigmas / std::sqrt(2.0));
        const auto beyond = std::count_if(sample.begin(), sample.end(),
                                          [=](double x) { return std::abs(x) > sigmas; });
        EXPECT_NEAR(static_cast<double>(beyond), expected, 4.0 * std::sqrt(expected)) << sigmas;
    }
}

TEST(Random, GaussianIsNormal) {
    Random random(12);
    expect_normal(draw([&] { return random.gaussian_float(); }));
    expect_normal(draw([&] { return random.gaussian_double(); }));
}

TEST(Random, SuccessiveGaussiansAreUncorrelated) {
    Random random(13);
    const auto sample = draw([&] { return random.gaussian_float(); });
    for (const std::size_t lag : {1u, 2u, 3u, 4u}) {
        double sum = 0.0;
        for (std::size_t i = lag; i < sample.size(); ++i) sum += sample[i] * sample[i - lag];
        EXPECT_NEAR(sum / kCount, 0.0, 4.0 / std::sqrt(kCount)) << lag;
    }
}

}  // namespace
}  // namespace stator::math
