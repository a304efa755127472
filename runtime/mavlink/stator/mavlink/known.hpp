// What a parser must know of a message to check its frames.
#pragma once

#include <cstdint>

namespace stator::mav {

struct Known {
    uint16_t id;
    uint8_t crc_extra;  // a checksum of the definition: both sides must have the same one
};

}  // namespace stator::mav
