// Coloured noise of simulated sensors, exactly integrated: the same statistics at any period.
#pragma once

#include "stator/random.hpp"
#include "stator/rotation.hpp"

namespace stator::world {

using Vector3 = math::Vector3<double>;

// Streams of random numbers of one seed: a sensor that is added or changed leaves the others'
// alone.
enum class Stream : std::uint64_t {
    kStart = 0,
    kImu = 1,
    kMocap = 2,
    kMagnetometer = 3,
    kBarometer = 4,
    kGnss = 5,
    kWind = 6,
    kVariation = 7,
    kImuDrift = 8,
};

// Standard normal, components in order: the arguments of a constructor have none.
Vector3 gaussian3(math::Random& random);

// Three independent first-order Gauss-Markov processes: x' = -x / tau + white noise, of standard
// deviation sigma each. They begin as if they had always run.
class GaussMarkov {
  public:
    GaussMarkov(const Vector3& sigma, double tau, double period, math::Random& random);

    const Vector3& value() const { return value_; }
    // One period later.
    const Vector3& next(math::Random& random);

  private:
    double decay_;
    Vector3 kick_;
    Vector3 value_;
};

}  // namespace stator::world
