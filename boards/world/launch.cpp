// How a flight begins.
#include "world/launch.hpp"

namespace stator::world {

LaunchParameters parameters_of(Launch launch) {
    constexpr double kDegree = math::kPi<double> / 180.0;
    constexpr std::uint64_t kWaits_us = 1'000'000;
    switch (launch) {
        case Launch::kGround:
            break;
        case Launch::kCatapult:  // as in the test of PX4's simulator in hardware
            return {1.5, 10.0 * kDegree, 10.0 * kDegree, 15.0, 50.0, kWaits_us};
        case Launch::kHand:
            return {1.8, 10.0 * kDegree, 5.0 * kDegree, 8.0, 25.0, kWaits_us};
    }
    return {};
}

Launcher::Launcher(Launch launch, double yaw, bool has_wing)
    : parameters_(parameters_of(launch)),
      has_wing_(has_wing),
      is_free_(launch == Launch::kGround && !has_wing) {
    const auto heading = math::sincos(yaw);
    const auto climb = math::sincos(parameters_.climb);
    way_N_ = Vector3(heading.cos * climb.cos, heading.sin * climb.cos, -climb.sin);
}

std::optional<Vector3> Launcher::catches_N(const Plant& plant, bool motors_are_stopped) {
    constexpr double kSlow = 3.0;   // m/s
    constexpr double kHolds = 5.0;  // 1/s
    const Vector3& velocity_N = plant.state().velocity_N;
    if (!has_wing_ || !motors_are_stopped) {
        is_caught_ = false;
    } else if (plant.is_on_ground() && math::norm(velocity_N) < kSlow) {
        is_caught_ = true;
    }
    if (!is_caught_) return {};
    const Vector3 down_N(0.0, 0.0, plant.is_on_ground() ? 0.0 : 1.0);
    return Vector3(down_N - kHolds * velocity_N);
}

std::optional<Vector3> Launcher::carries_N(const Plant& plant, bool motors_are_stopped) {
    if (is_free_) return catches_N(plant, motors_are_stopped);
    if (is_thrown_) {
        is_free_ = plant.state().velocity_N.dot(way_N_) >= parameters_.speed;
        if (is_free_) return {};
        return parameters_.acceleration * way_N_;
    }
    if (motors_are_stopped) {
        allowed_us_.reset();
    } else if (!allowed_us_) {
        allowed_us_ = plant.time_us();
    }
    is_thrown_ = allowed_us_ && plant.time_us() - *allowed_us_ >= parameters_.waits_us;
    return is_thrown_ ? Vector3(parameters_.acceleration * way_N_) : Vector3(Vector3::Zero());
}

}  // namespace stator::world
