// How a flight begins: on the ground, or from a catapult or a hand.
#pragma once

#include <cstdint>
#include <optional>

#include "world/plant.hpp"

namespace stator::world {

enum class Launch : std::uint8_t { kGround, kCatapult, kHand };

struct LaunchParameters {
    double height;           // m, above where the vehicle rests
    double pitch;            // rad, of the vehicle
    double climb;            // rad, of the way it goes
    double speed;            // m/s, at which it is free
    double acceleration;     // m/s^2
    std::uint64_t waits_us;  // from when a motor may turn
};
LaunchParameters parameters_of(Launch launch);

// Holds the vehicle, and throws it once its motors have been allowed to turn for a while. What has
// a wing is held on the ground, too, until then and after it has landed: a gust would lift it.
class Launcher {
  public:
    Launcher(Launch launch, double yaw, bool has_wing);

    // To be called in steps of 1 ms or so: how the vehicle is moved until the next call. Nothing:
    // it is free.
    std::optional<Vector3> carries_N(const Plant& plant, bool motors_are_stopped);

  private:
    std::optional<Vector3> catches_N(const Plant& plant, bool motors_are_stopped);

    LaunchParameters parameters_;
    Vector3 way_N_;  // of unit length
    bool has_wing_;
    bool is_free_;
    bool is_caught_ = false;
    bool is_thrown_ = false;
    std::optional<std::uint64_t> allowed_us_;
};

}  // namespace stator::world
