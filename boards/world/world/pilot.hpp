// The pilot of a simulated flight, whose hands follow a script.
//
// A row says when, and where sticks and switches are from then on:
//     seconds roll pitch yaw throttle mode_slot arm return kill
// Sticks -1 to 1, mode slot 0 to 6, switches 0 or 1. Empty lines and lines with # do not count.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace stator::world {

struct PilotFrame {
    std::uint64_t time_us = 0;
    float roll = 0.0F;
    float pitch = 0.0F;
    float yaw = 0.0F;
    float throttle = 0.0F;
    unsigned mode_slot = 1;
    bool arm = false;
    bool return_home = false;
    bool kill = false;
};

class Pilot {
  public:
    static constexpr std::uint64_t kPeriod_us = 20000;  // between frames of a common receiver

    // Leaves the sticks alone, chooses mode slot 1, and arms after a second.
    Pilot();
    // Touches neither sticks nor switches.
    void leave_alone() { frames_ = {PilotFrame{}}; }
    // Follows the script in place of that. On an error, what is wrong; nothing has changed then.
    [[nodiscard]] std::string follow(std::string_view script);

    // Hands at this time.
    const PilotFrame& frame(std::uint64_t time_us) const;

  private:
    std::vector<PilotFrame> frames_;  // in order of time, the first at 0
};

}  // namespace stator::world
