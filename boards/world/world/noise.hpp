// Coloured noise of simulated sensors, exactly integrated: the same statistics at any period.
#pragma once

#include <cstdint>
#include <string_view>

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
// The stream of a sensor that is not in that list, by a name of its own (FNV-1a; the highest bit
// keeps it from the numbers above).
constexpr std::uint64_t stream_of(std::string_view name) {
    std::uint64_t hash = 0xcbf29ce484222325;
    for (const char letter : name) {
        hash = (hash ^ static_cast<unsigned char>(letter)) * 0x100000001b3;
    }
    return hash | std::uint64_t{1} << 63;
}

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
