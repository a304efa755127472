// Motion capture that sends MAVLink 2's ATT_POS_MOCAP over a serial line, as bridges to cameras do.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "mocap_ports.hpp"

namespace stator::drivers::mocap::mavlink {

class MocapMavlink {
  public:
    struct Device {
        // What came in on the line since the last call, as far as there is room. The board puts its
        // function here, and raises `received` when the line pauses.
        size_t (*read)(std::span<uint8_t> bytes) = nullptr;
        // From the picture to the pause behind its message: the message's own time is of another
        // clock.
        uint32_t delay_us = 0;
        uint32_t damaged = 0;  // messages with a wrong checksum
    };

    explicit MocapMavlink(Device& device) : device_(device) {}
    void step(MocapPorts& ports);

  private:
    struct Pose {
        std::array<float, 4> q;         // w, x, y, z: body in N
        std::array<float, 3> position;  // m, in N
    };

    std::optional<Pose> take(uint8_t byte);
    std::optional<Pose> pose() const;

    static constexpr size_t kHead = 10;
    static constexpr size_t kMaxPayload = 255;
    static constexpr size_t kChecksum = 2;

    Device& device_;
    std::array<uint8_t, kHead + kMaxPayload + kChecksum> frame_{};
    size_t filled_ = 0;
};

}  // namespace stator::drivers::mocap::mavlink
