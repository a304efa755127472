// What a parser must know of a message to check its frames.
#pragma once

#include <cstdint>

namespace stator::mav {

struct Known {
    static constexpr uint8_t kNoTarget = 0xFF;
    static constexpr uint8_t kHasComponent = 0x80;

    uint16_t id;
    uint8_t crc_extra;  // a checksum of the definition: both sides must have the same one
    // Where the payload has the system that it is for, and whether the component follows it.
    uint8_t target;
};

}  // namespace stator::mav
