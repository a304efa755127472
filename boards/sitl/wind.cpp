// The simulated wind.
#include "wind.hpp"

namespace stator::board {

namespace {

constexpr double kFoot = 0.3048;           // m
constexpr double kKnot = 1852.0 / 3600.0;  // m/s
constexpr double kLowest = 10.0;           // ft, where the model's heights begin,
constexpr double kHighest = 1000.0;        // and end

// Wind at 20 ft that the intensities are named for.
double wind_at_20_ft(Gusts gusts) {
    switch (gusts) {
        case Gusts::kNone:
            return 0.0;
        case Gusts::kLight:
            return 15.0 * kKnot;
        case Gusts::kModerate:
            return 30.0 * kKnot;
        case Gusts::kSevere:
            return 45.0 * kKnot;
    }
    return 0.0;
}

}  // namespace

double LongitudinalGust::next(double step, math::Random& random) {
    const double decay = math::exp(-step);
    state_ = decay * state_ + math::sqrt(1.0 - decay * decay) * random.gaussian_double();
    return state_;
}

// With x' = (n - x) / T and y' = (x - y) / T, the filter is sqrt(3) x + (1 - sqrt(3)) y. Where x
// has variance 1, that of y and the covariance are 1/2, and that of the sum is 2.
double TransverseGust::next(double step, math::Random& random) {
    const double decay = math::exp(-step);
    const double decay2 = decay * decay;
    // Covariance of what one step adds: P - Phi P Phi', Phi = decay [1 0; step 1].
    const double q11 = 1.0 - decay2;
    const double q12 = 0.5 - decay2 * (step + 0.5);
    const double q22 = 0.5 - decay2 * (step * step + step + 0.5);
    const double l11 = math::sqrt(q11);
    const double l21 = q12 / l11;
    const double l22 = math::sqrt(math::max(q22 - l21 * l21, 0.0));
    const double a = random.gaussian_double();
    const double b = random.gaussian_double();
    second_ = decay * (second_ + step * first_) + l21 * a + l22 * b;
    first_ = decay * first_ + l11 * a;
    constexpr double kSqrt3 = 1.7320508075688772;
    constexpr double kSqrtHalf = 0.70710678118654752;
    return kSqrtHalf * (kSqrt3 * first_ + (1.0 - kSqrt3) * second_);
}

GustScale gust_scale(Gusts gusts, double height) {
    const double feet = math::clamp(height / kFoot, kLowest, kHighest);
    const double base = 0.177 + 0.000823 * feet;
    const double sigma_vertical = 0.1 * wind_at_20_ft(gusts);
    return {.level = kFoot * feet / math::pow(base, 1.2),
            .vertical = kFoot * feet,
            .sigma_level = sigma_vertical / math::pow(base, 0.4),
            .sigma_vertical = sigma_vertical};
}

Wind::Wind(const WindParameters& parameters, std::uint64_t seed)
    : parameters_(parameters),
      random_(seed, static_cast<std::uint64_t>(Stream::kWind)),
      from_(math::sincos(parameters.from)) {
    // Long enough that the filters are as if they had always run.
    constexpr double kStep = 1.0;
    for (unsigned i = 0; i < 64; ++i) {
        along_.next(kStep, random_);
        across_.next(kStep, random_);
        down_.next(kStep, random_);
    }
}

Vector3 Wind::next_gust(double height, double airspeed) {
    const GustScale scale = gust_scale(parameters_.gusts, height);
    const double passed = math::max(airspeed, kMinAirspeed) * 1e-6 * kGustPeriod_us;
    const double along = scale.sigma_level * along_.next(passed / scale.level, random_);
    const double across = scale.sigma_level * across_.next(passed / scale.level, random_);
    const double down = scale.sigma_vertical * down_.next(passed / scale.vertical, random_);
    return {-from_.cos * along + from_.sin * across, -from_.sin * along - from_.cos * across, down};
}

Vector3 Wind::at(std::uint64_t time_us, double height, double airspeed) {
    const Vector3 mean_N = -parameters_.speed * Vector3(from_.cos, from_.sin, 0.0);
    if (parameters_.gusts == Gusts::kNone) return mean_N;
    while (next_us_ <= time_us) {
        gust_N_ = next_gust_N_;
        next_gust_N_ = next_gust(height, airspeed);
        next_us_ += kGustPeriod_us;
    }
    const double left = static_cast<double>(next_us_ - time_us) / kGustPeriod_us;
    return mean_N + left * gust_N_ + (1.0 - left) * next_gust_N_;
}

}  // namespace stator::board
