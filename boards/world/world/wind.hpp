// The simulated wind: a mean, and gusts around it.
//
// Gusts are Dryden's, with scales and intensities of MIL-F-8785C, 3.7.3.4 (below 1000 ft): by
// height h in ft and wind W20 at 20 ft, along the mean wind (u), across (v) and down (w):
//   L_w = h, L_u = L_v = h / (0.177 + 0.000823 h)^1.2
//   sigma_w = 0.1 W20, sigma_u = sigma_v = sigma_w / (0.177 + 0.000823 h)^0.4
// Their spectra are those of white noise behind
//   u: 1 / (1 + T s),   v and w: (1 + sqrt(3) T s) / (1 + T s)^2,   T = L / airspeed
// Both filters are integrated exactly at unit variance, so that the period changes no statistics.
#pragma once

#include <cstdint>

#include "world/noise.hpp"

namespace stator::world {

enum class Gusts : std::uint8_t { kNone, kLight, kModerate, kSevere };

struct WindParameters {
    double speed = 0.0;  // m/s, the same at all heights
    double from = 0.0;   // rad, from north over east, as weather reports have it
    Gusts gusts = Gusts::kNone;
};

// White noise of unit variance behind one of the filters above.
class LongitudinalGust {
  public:
    // `step`: seconds over T.
    double next(double step, math::Random& random);

  private:
    double state_ = 0.0;
};
class TransverseGust {
  public:
    double next(double step, math::Random& random);

  private:
    double first_ = 0.0;   // behind 1 / (1 + T s)
    double second_ = 0.0;  // behind that twice
};

struct GustScale {
    double level;     // m, L_u and L_v
    double vertical;  // m, L_w
    double sigma_level;
    double sigma_vertical;  // m/s
};
GustScale gust_scale(Gusts gusts, double height);

class Wind {
  public:
    static constexpr std::uint64_t kGustPeriod_us = 10000;  // a straight line in between
    static constexpr double kMinAirspeed = 3.0;  // m/s; slower, gusts change by themselves

    Wind(const WindParameters& parameters, std::uint64_t seed);

    // Over N, at a time that never goes back. `airspeed`: how fast gusts pass the vehicle.
    Vector3 at(std::uint64_t time_us, double height, double airspeed);

    // Along the mean wind, of unit length.
    Vector3 direction() const { return {-from_.cos, -from_.sin, 0.0}; }

  private:
    Vector3 next_gust(double height, double airspeed);

    WindParameters parameters_;
    math::Random random_;
    math::SinCos<double> from_;
    LongitudinalGust along_;
    TransverseGust across_;
    TransverseGust down_;
    std::uint64_t next_us_ = 0;
    Vector3 gust_N_ = Vector3::Zero();       // a period before next_us_
    Vector3 next_gust_N_ = Vector3::Zero();  // at next_us_
};

}  // namespace stator::world
