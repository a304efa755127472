// Follows the true flight: when the vehicle took off, how hard it came down, when all is over.
#pragma once

#include <cstdint>
#include <optional>

#include "world/plant.hpp"

namespace stator::world {

// A vehicle flies once it has climbed this far; less is a hop on its landing gear.
inline constexpr double kAirborneHeight = 0.1;  // m
// A flight is over when the motors have stood still for so long.
inline constexpr std::uint64_t kStandstill_us = 1'000'000;

class FlightWatch {
  public:
    struct Touchdown {
        std::uint64_t time_us;
        double speed;  // m/s down, just before
    };

    explicit FlightWatch(const Plant& plant) : start_z_(plant.state().position_N.z()) {}

    // To be called in steps of 1 ms or so.
    void see(const Plant& plant, bool motors_are_stopped);

    std::optional<std::uint64_t> take_off_us() const { return take_off_us_; }
    std::optional<Touchdown> touchdown() const { return touchdown_; }
    bool is_over(std::uint64_t now_us) const;

  private:
    double start_z_;
    double sink_speed_ = 0.0;
    std::optional<std::uint64_t> take_off_us_;  // when it left the ground
    std::optional<std::uint64_t> left_ground_us_;
    std::optional<Touchdown> touchdown_;
    std::optional<std::uint64_t> stopped_us_;
};

}  // namespace stator::world
