// The checksum of a transfer of several frames: CRC-16-CCITT-FALSE, begun with the signature of the
// data type, so that two nodes that disagree on a type do not understand each other by chance.
#pragma once

#include <cstdint>
#include <span>

namespace stator::dronecan {

// `crc` continued over one byte. Polynomial 0x1021, most significant bit first.
constexpr uint16_t crc16(uint16_t crc, uint8_t byte) {
    unsigned value = crc ^ (static_cast<unsigned>(byte) << 8);
    for (int bit = 0; bit < 8; ++bit) value = (value << 1) ^ ((value & 0x8000) != 0 ? 0x1021 : 0);
    return static_cast<uint16_t>(value);
}

// What the checksum of a transfer begins with: that of the type's signature, lowest byte first.
constexpr uint16_t crc_seed(uint64_t signature) {
    uint16_t crc = 0xFFFF;
    for (unsigned i = 0; i < 8; ++i) crc = crc16(crc, static_cast<uint8_t>(signature >> (8 * i)));
    return crc;
}

[[nodiscard]] uint16_t crc16(uint16_t seed, std::span<const uint8_t> bytes);

}  // namespace stator::dronecan
