// The checksum of a transfer of several frames.
#include "stator/dronecan/crc.hpp"

namespace stator::dronecan {

uint16_t crc16(uint16_t seed, std::span<const uint8_t> bytes) {
    uint16_t crc = seed;
    for (const uint8_t byte : bytes) crc = crc16(crc, byte);
    return crc;
}

}  // namespace stator::dronecan
