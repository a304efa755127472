// Coloured noise of simulated sensors.
#include "world/noise.hpp"

namespace stator::world {

Vector3 gaussian3(math::Random& random) {
    Vector3 result;
    for (double& component : result) component = random.gaussian_double();
    return result;
}

GaussMarkov::GaussMarkov(const Vector3& sigma, double tau, double period, math::Random& random)
    : decay_(math::exp(-period / tau)),
      kick_(sigma * math::sqrt(1.0 - decay_ * decay_)),
      value_(sigma.cwiseProduct(gaussian3(random))) {}

const Vector3& GaussMarkov::next(math::Random& random) {
    value_ = decay_ * value_ + kick_.cwiseProduct(gaussian3(random));
    return value_;
}

}  // namespace stator::world
