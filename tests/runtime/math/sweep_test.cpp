// Accuracy over very many arguments: float functions against the double ones at every n-th of all
// floats, double functions against the C library's 80-bit ones where the machine has those.
//
// STATOR_SWEEP_STRIDE in the environment is n, 1 for all 2^32; the default is quick.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <iostream>

#include "stator/random.hpp"
#include "stator/scalar.hpp"
#include "ulp.hpp"

namespace stator::math {
namespace {

constexpr std::uint64_t kQuickStride = 9973;  // prime, so that all fractions come up

std::uint64_t stride() {
    const char* text = std::getenv("STATOR_SWEEP_STRIDE");
    return text != nullptr ? std::strtoull(text, nullptr, 10) : kQuickStride;
}

struct Worst {
    double error = 0.0;
    double x = 0.0;
    double y = 0.0;

    void see(double new_error, double new_x, double new_y) {
        if (!(new_error > error)) return;
        error = new_error;
        x = new_x;
        y = new_y;
    }
};

void expect_below(double largest, const Worst& worst) {
    EXPECT_LE(worst.error, largest) << std::hexfloat << "x " << worst.x << " y " << worst.y;
    ::testing::Test::RecordProperty("largest_error_ulp", std::to_string(worst.error));
    std::cout << "largest error " << worst.error << " ulp\n";
}

// Out of float's range, the function has to say infinity; a NaN has to be one in both.
double float_error(float value, double truth) {
    if (is_nan(truth)) return is_nan(value) ? 0.0 : 1e30;
    constexpr double kOverflow = 0x1p128 - 0x1p103;
    if (abs(truth) >= kOverflow) return value == static_cast<float>(truth) ? 0.0 : 1e30;
    return ulp_error(value, truth, 0.0);
}

template <typename Function>
void sweep_floats(double largest, Function function) {
    Worst worst;
    const std::uint64_t step = stride();
    for (std::uint64_t bits = 0; bits < 0x100000000u; bits += step) {
        const auto x = from_bits<float>(static_cast<std::uint32_t>(bits));
        const auto wide = static_cast<double>(x);
        worst.see(float_error(function(x), function(wide)), wide, 0.0);
    }
    expect_below(largest, worst);
}

TEST(FloatSweep, Sin) {
    sweep_floats(limit::kSin, [](auto x) { return sin(x); });
}
TEST(FloatSweep, Cos) {
    sweep_floats(limit::kCos, [](auto x) { return cos(x); });
}
TEST(FloatSweep, Tan) {
    sweep_floats(limit::kTan, [](auto x) { return tan(x); });
}
TEST(FloatSweep, WrapPi) {
    // What float leaves as it is, double may not: float's pi is greater than double's.
    sweep_floats(limit::kWrapPi, [](auto x) {
        const bool as_it_is = abs(x) <= static_cast<decltype(x)>(kPi<float>);
        return as_it_is ? x : wrap_pi(x);
    });
}
TEST(FloatSweep, Atan) {
    sweep_floats(limit::kAtan, [](auto x) { return atan(x); });
}
TEST(FloatSweep, Asin) {
    sweep_floats(limit::kAsin, [](auto x) { return asin(x); });
}
TEST(FloatSweep, Acos) {
    sweep_floats(limit::kAcos, [](auto x) { return acos(x); });
}
TEST(FloatSweep, Exp) {
    sweep_floats(limit::kExp, [](auto x) { return exp(x); });
}
TEST(FloatSweep, Log) {
    sweep_floats(limit::kLog, [](auto x) { return log(x); });
}
TEST(FloatSweep, Sqrt) {
    sweep_floats(limit::kSqrt, [](auto x) { return sqrt(x); });
}

TEST(FloatSweep, SincosIsSinAndCos) {
    const std::uint64_t step = stride();
    for (std::uint64_t bits = 0; bits < 0x100000000u; bits += step) {
        const auto x = from_bits<float>(static_cast<std::uint32_t>(bits));
        const SinCos<float> both = sincos(x);
        ASSERT_EQ(to_bits(both.sin), to_bits(sin(x))) << std::hexfloat << x;
        ASSERT_EQ(to_bits(both.cos), to_bits(cos(x))) << std::hexfloat << x;
    }
}

TEST(FloatSweep, SqrtByIntegersIsTheInstruction) {
    const std::uint64_t step = stride();
    for (std::uint64_t bits = 0; bits < 0x100000000u; bits += step) {
        const auto x = from_bits<float>(static_cast<std::uint32_t>(bits));
        ASSERT_EQ(to_bits(canonical(detail::sqrt_by_integers(x))), to_bits(canonical(sqrt(x))))
            << std::hexfloat << x;
    }
}

// The random arguments that follow are the same on every run.
constexpr std::uint64_t kSeed = 20;

double between(Random& random, double low, double high) {
    return low + (high - low) * random.uniform_double();
}

// Of any sign and exponent.
double anything(Random& random) {
    const std::uint64_t high = random.word();
    const std::uint64_t low = random.word();
    const auto x = from_bits<double>((high << 32) | low);
    return is_finite(x) ? x : anything(random);
}

std::uint64_t random_count() {
    return 1500000000u / stride();
}

double double_error(double value, long double truth) {
    if (is_nan(value)) return 1e30;
    const auto rounded = static_cast<double>(truth);
    if (!is_finite(rounded)) return value == rounded ? 0.0 : 1e30;
    return std::abs(static_cast<double>((static_cast<long double>(value) - truth) /
                                        static_cast<long double>(spacing<double>(rounded))));
}

// Compares at arguments from `sample`, which returns {x, y}.
template <typename Sample, typename Function, typename Truth>
void compare_doubles(double largest, Sample sample, Function function, Truth truth) {
    if (std::numeric_limits<long double>::digits < 64) GTEST_SKIP() << "no 80-bit long double";
    Random random(kSeed);
    Worst worst;
    for (std::uint64_t left = random_count(); left > 0; --left) {
        const auto [x, y] = sample(random);
        worst.see(double_error(function(x, y), truth(x, y)), x, y);
    }
    expect_below(largest, worst);
}

struct Arguments {
    double x;
    double y;
};

// Half of them small, half of any size.
Arguments angle(Random& random) {
    const double x = random.word() % 2 == 0 ? between(random, -10.0, 10.0) : anything(random);
    return {x, 0.0};
}

Arguments unit(Random& random) {
    return {between(random, -1.0, 1.0), 0.0};
}

Arguments exponent(Random& random) {
    const double size = random.word() % 2 == 0 ? 1.0 : 746.0;
    return {between(random, -size, size), 0.0};
}

Arguments positive(Random& random) {
    return {random.word() % 2 == 0 ? between(random, 0.5, 2.0) : abs(anything(random)), 0.0};
}

Arguments direction(Random& random) {
    const double scale = random.word() % 2 == 0 ? 1.0 : abs(anything(random)) * 0x1p-10;
    const double y = scale * between(random, -1.0, 1.0);
    return {y, scale * between(random, -1.0, 1.0)};
}

Arguments power(Random& random) {
    const double base = positive(random).x;
    return {base, between(random, -746.0, 710.0) / std::log(base)};
}

#define COMPARE(largest, sample, name)                             \
    compare_doubles(                                               \
        largest, sample, [](double x, double) { return name(x); }, \
        [](double x, double) { return std::name(static_cast<long double>(x)); })
#define COMPARE_2(largest, sample, name)                                                \
    compare_doubles(                                                                    \
        largest, sample, [](double x, double y) { return name(x, y); },                 \
        [](double x, double y) {                                                        \
            return std::name(static_cast<long double>(x), static_cast<long double>(y)); \
        })

TEST(DoubleRandom, Sin) {
    COMPARE(limit::kSin, angle, sin);
}
TEST(DoubleRandom, Cos) {
    COMPARE(limit::kCos, angle, cos);
}
TEST(DoubleRandom, Tan) {
    COMPARE(limit::kTan, angle, tan);
}
TEST(DoubleRandom, Atan) {
    COMPARE(limit::kAtan, angle, atan);
}
TEST(DoubleRandom, Asin) {
    COMPARE(limit::kAsin, unit, asin);
}
TEST(DoubleRandom, Acos) {
    COMPARE(limit::kAcos, unit, acos);
}
TEST(DoubleRandom, Exp) {
    COMPARE(limit::kExp, exponent, exp);
}
TEST(DoubleRandom, Log) {
    COMPARE(limit::kLog, positive, log);
}
TEST(DoubleRandom, Sqrt) {
    COMPARE(limit::kSqrt, positive, sqrt);
}
TEST(DoubleRandom, Atan2) {
    COMPARE_2(limit::kAtan2, direction, atan2);
}
TEST(DoubleRandom, Pow) {
    COMPARE_2(limit::kPow, power, pow);
}

TEST(DoubleRandom, SqrtByIntegersIsTheInstruction) {
    Random random(kSeed);
    for (std::uint64_t left = random_count(); left > 0; --left) {
        const double x = anything(random);
        ASSERT_EQ(to_bits(canonical(detail::sqrt_by_integers(x))), to_bits(canonical(sqrt(x))))
            << std::hexfloat << x;
    }
}

// Too many pairs for a sweep.
template <typename Sample, typename Function>
void compare_floats(double largest, Sample sample, Function function) {
    Random random(kSeed);
    Worst worst;
    for (std::uint64_t left = random_count(); left > 0; --left) {
        const auto [x, y] = sample(random);
        const double error =
            float_error(function(x, y), function(static_cast<double>(x), static_cast<double>(y)));
        worst.see(error, static_cast<double>(x), static_cast<double>(y));
    }
    expect_below(largest, worst);
}

struct FloatArguments {
    float x;
    float y;
};

float any_float(Random& random) {
    const auto x = from_bits<float>(random.word());
    return is_finite(x) ? x : any_float(random);
}

TEST(FloatRandom, Atan2) {
    const auto sample = [](Random& random) -> FloatArguments {
        const float scale = random.word() % 2 == 0 ? 1.0f : abs(any_float(random)) * 0x1p-8f;
        const float y = scale * (random.uniform_float() - 0.5f);
        return {y, scale * (random.uniform_float() - 0.5f)};
    };
    compare_floats(limit::kAtan2, sample, [](auto y, auto x) { return atan2(y, x); });
}

TEST(FloatRandom, Pow) {
    const auto sample = [](Random& random) -> FloatArguments {
        const bool near_one = random.word() % 2 == 0;
        const float base = near_one ? 0.5f + random.uniform_float() : abs(any_float(random));
        const double y = between(random, -104.0, 89.0) / std::log(static_cast<double>(base));
        return {base, abs(y) < 1e38 ? static_cast<float>(y) : 1.0f};
    };
    compare_floats(limit::kPow, sample, [](auto x, auto y) { return pow(x, y); });
}

}  // namespace
}  // namespace stator::math
