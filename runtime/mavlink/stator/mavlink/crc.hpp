// The checksum of a frame: CRC-16/MCRF4XX, over all behind the start byte, and CRC_EXTRA.
#pragma once

#include <cstdint>
#include <span>

namespace stator::mav {

inline constexpr uint16_t kCrcSeed = 0xFFFF;

// `crc` continued over one byte. Polynomial 0x1021, least significant bit first.
constexpr uint16_t crc16(uint16_t crc, uint8_t byte) {
    const auto low = static_cast<uint8_t>(byte ^ crc);
    const auto mixed = static_cast<uint8_t>(low ^ (low << 4));
    return static_cast<uint16_t>((crc >> 8) ^ (mixed << 8) ^ (mixed << 3) ^ (mixed >> 4));
}

constexpr uint16_t crc16(uint16_t crc, std::span<const uint8_t> bytes) {
    for (const uint8_t byte : bytes) crc = crc16(crc, byte);
    return crc;
}

}  // namespace stator::mav
