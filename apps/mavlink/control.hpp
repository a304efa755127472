// What stations steer with: sticks, setpoints of the mode offboard, and that they are there.
#pragma once

#include <cstdint>
#include <optional>

#include "link.hpp"
#include "mavlink_ports.hpp"
#include "stator/mavlink/frame.hpp"
#include "telemetry.hpp"

namespace stator::apps::mavlink {

// Passes on the newest of each in an activation. Sticks and setpoints of one sender count until it
// is silent for a while, so that two never take turns. A setpoint with a number that is none, or
// that leaves an axis free, is not passed on: the one before it ages, until it counts as lost.
class Control {
  public:
    // Whether it was a message for this.
    bool handle(const Link& link, unsigned line, const mav::Frame& frame,
                const Telemetry& telemetry, const MavlinkPorts& ports);
    // Once in each activation, behind all messages.
    void publish(MavlinkPorts& ports);

  private:
    static constexpr uint64_t kSilent_us = 500'000;

    // Who is heard.
    class Sender {
      public:
        bool takes(unsigned line, mav::Address from, uint64_t now_us);

      private:
        unsigned line_ = 0;
        mav::Address from_{};
        uint64_t heard_us_ = 0;
    };

    void take_sticks(const mav::ManualControl& control, uint64_t now_us);
    void take_position(const mav::SetPositionTargetLocalNed& target, const MavlinkPorts& ports);
    void take_global(const mav::SetPositionTargetGlobalInt& target, const Telemetry& telemetry);
    void take_attitude(const mav::SetAttitudeTarget& target);

    Sender pilot_;
    Sender companion_;
    std::optional<ManualControlSetpoint> sticks_;
    std::optional<OffboardSetpoint> setpoint_;
    std::optional<StationHeartbeat> station_;
};

}  // namespace stator::apps::mavlink
