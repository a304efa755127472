// The checksum by which a ground station tells whether it knows all parameters already: MAVLink's
// `_HASH_CHECK`, as PX4 computes it.
#pragma once

#include <cstdint>
#include <string_view>

#include "stator/crc32.hpp"
#include "stator/parameters.hpp"

namespace stator {

// CRC-32 without the inversions before and after: of what `crc` covers and these bytes behind it; 0
// covers nothing. MAVLink's file transfer uses it, too.
inline uint32_t plain_crc32(uint32_t crc, const void* data, size_t count) {
    return ~crc32(~crc, data, count);
}

// Of all parameters in the order of their ids: what `hash` covers and this one behind it. A bool is
// an int32.
inline uint32_t hash_parameter(uint32_t hash, std::string_view id, ParameterBits value) {
    return plain_crc32(plain_crc32(hash, id.data(), id.size()), &value, sizeof value);
}

}  // namespace stator
