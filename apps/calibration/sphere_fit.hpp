// The centre of a sphere from points on it: what a magnetometer's own vehicle adds to the field.
#pragma once

#include <array>
#include <optional>

#include "stator/rotation.hpp"

namespace stator::apps::calibration {

// Least squares: |m|^2 = 2 c . m + k is linear in the centre c and in k = r^2 - |c|^2 (I. D. Coope,
// "Circle fitting by linear and nonlinear least squares", 1993). Points count from the first one,
// so that the sums stay small. A point close to the one before is left out: a sensor that is held
// still would count too much.
class SphereFit {
  public:
    struct Sphere {
        math::Vector3<float> centre;
        float radius;
        float error;  // rms of the points' distances from the sphere, about
    };

    void clear() { *this = {}; }
    void add(const math::Vector3<float>& point);
    unsigned count() const { return count_; }
    // How much of a turn about every axis has been seen: 0 to 1.
    float coverage() const;
    // None: the points do not lie around a centre.
    std::optional<Sphere> fit() const;

  private:
    static constexpr float kApart = 0.03F;  // gauss
    static constexpr float kLeastSpan = 0.3F;

    math::Vector3<float> first_ = math::Vector3<float>::Zero();
    math::Vector3<float> last_ = math::Vector3<float>::Zero();
    math::Vector3<float> least_ = math::Vector3<float>::Zero();
    math::Vector3<float> most_ = math::Vector3<float>::Zero();
    std::array<std::array<float, 5>, 4> sums_{};  // of the normal equations, and their right side
    float square_sum_ = 0.0F;                     // of |m|^4
    unsigned count_ = 0;
};

}  // namespace stator::apps::calibration
