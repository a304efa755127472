// MAVLink 2's message of a motion capture, as a bridge to its cameras sends it.
#pragma once

#include <array>
#include <cstdint>
#include <cstring>
#include <span>

#include "stator/scalar.hpp"

namespace stator::plant {

// Frame, payload (time_usec, q, x, y, z) and checksum: mavlink.io, "Packet Serialization".
using AttPosMocap = std::array<uint8_t, 10 + 36 + 2>;

inline AttPosMocap att_pos_mocap(uint8_t sequence, uint64_t time_us,
                                 const std::array<float, 3>& position, float yaw) {
    const math::SinCos<float> half = math::sincos(0.5F * yaw);
    const std::array<float, 7> pose{half.cos,    0.0F,        0.0F,       half.sin,
                                    position[0], position[1], position[2]};
    AttPosMocap frame{0xFD, 36, 0, 0, sequence, 1, 197, 138, 0, 0};  // of a bridge
    std::memcpy(&frame[10], &time_us, sizeof time_us);
    std::memcpy(&frame[18], pose.data(), sizeof pose);
    // CRC-16/MCRF4XX by bits, over all but the first byte, and the message's own seed.
    uint16_t sum = 0xFFFF;
    const auto add = [&](uint8_t byte) {
        sum = static_cast<uint16_t>(sum ^ byte);
        for (int i = 0; i < 8; ++i) {
            sum = static_cast<uint16_t>((sum & 1) != 0 ? sum >> 1 ^ 0x8408 : sum >> 1);
        }
    };
    for (const uint8_t byte : std::span(frame).subspan(1, 9 + 36)) add(byte);
    add(109);
    frame[46] = static_cast<uint8_t>(sum);
    frame[47] = static_cast<uint8_t>(sum >> 8);
    return frame;
}

}  // namespace stator::plant
