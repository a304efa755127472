// The frame of MAVLink 2 (mavlink.io, "Packet Serialization"): 0xFD, length of the payload, two
// bytes of flags, sequence, system, component, message in 3 bytes, payload, checksum; least
// significant byte first. Zeros at the payload's end are left out.
#include "mocap_mavlink.hpp"

#include <bit>

namespace stator::drivers::mocap::mavlink {

namespace {

constexpr uint8_t kStart = 0xFD;
constexpr size_t kLength = 1;
constexpr size_t kMessage = 7;
// ATT_POS_MOCAP: time of the sender (uint64), q (float[4]), x, y, z (float); 84 bytes more are
// optional.
constexpr uint32_t kAttPosMocap = 138;
constexpr uint8_t kSeed = 109;  // CRC_EXTRA of this message
constexpr size_t kQuaternion = 8;
constexpr size_t kPosition = 24;

// CRC-16/MCRF4XX, as in MAVLink's checksum.h.
uint16_t checksum(uint16_t sum, uint8_t byte) {
    auto mixed = static_cast<uint8_t>(byte ^ (sum & 0xFF));
    mixed = static_cast<uint8_t>(mixed ^ (mixed << 4));
    return static_cast<uint16_t>(sum >> 8 ^ mixed << 8 ^ mixed << 3 ^ mixed >> 4);
}

}  // namespace

void MocapMavlink::step(MocapPorts& ports) {
    if (device_.read == nullptr) return;
    std::optional<Pose> newest;
    std::array<uint8_t, 64> bytes;
    while (const size_t count = device_.read(bytes)) {
        for (size_t i = 0; i < count; ++i) {
            if (const auto taken = take(bytes[i])) newest = taken;
        }
    }
    if (!newest || ports.now < device_.delay_us) return;
    ports.odometry.publish([&] {
        return VehicleOdometry{.timestamp_sample = ports.now - device_.delay_us,
                               .position = newest->position,
                               .q = newest->q};
    });
}

// The pose, if the byte is the last one of a whole message that has one.
std::optional<MocapMavlink::Pose> MocapMavlink::take(uint8_t byte) {
    if (filled_ == 0 && byte != kStart) return {};
    frame_[filled_++] = byte;
    if (filled_ < kHead || filled_ < kHead + frame_[kLength] + kChecksum) return {};
    filled_ = 0;
    const auto message = static_cast<uint32_t>(frame_[kMessage] | frame_[kMessage + 1] << 8 |
                                               frame_[kMessage + 2] << 16);
    if (message != kAttPosMocap) return {};
    const size_t end = kHead + frame_[kLength];
    uint16_t sum = 0xFFFF;
    for (size_t i = 1; i < end; ++i) sum = checksum(sum, frame_[i]);
    sum = checksum(sum, kSeed);
    if (frame_[end] == (sum & 0xFF) && frame_[end + 1] == sum >> 8) return pose();
    ++device_.damaged;
    return {};
}

std::optional<MocapMavlink::Pose> MocapMavlink::pose() const {
    const auto number = [&](size_t at) {
        uint32_t bits = 0;
        for (size_t i = 0; i < sizeof bits; ++i) {
            const uint32_t byte = at + i < frame_[kLength] ? frame_[kHead + at + i] : 0;
            bits |= byte << 8 * i;
        }
        return std::bit_cast<float>(bits);
    };
    Pose found;
    for (size_t i = 0; i < 4; ++i) found.q[i] = number(kQuaternion + 4 * i);
    for (size_t i = 0; i < 3; ++i) found.position[i] = number(kPosition + 4 * i);
    return found;
}

}  // namespace stator::drivers::mocap::mavlink
