// CRC-32 as zlib and Ethernet have it: polynomial 0x04C11DB7 reflected, all ones before and after.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>

namespace stator {

namespace detail {

using CrcTable = std::array<uint32_t, 256>;

// Table k advances a byte by k further bytes of zeros, so that four bytes are done at once
// (Kounavis and Berry, 2005, "slicing by 4").
constexpr std::array<CrcTable, 4> crc_tables() {
    std::array<CrcTable, 4> tables{};
    for (uint32_t byte = 0; byte < 256; ++byte) {
        uint32_t crc = byte;
        for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1) ^ ((crc & 1U) != 0 ? 0xEDB88320U : 0U);
        tables[0][byte] = crc;
    }
    for (uint32_t byte = 0; byte < 256; ++byte) {
        for (size_t k = 1; k < 4; ++k) {
            const uint32_t before = tables[k - 1][byte];
            tables[k][byte] = (before >> 8) ^ tables[0][before & 0xFFU];
        }
    }
    return tables;
}

inline constexpr std::array<CrcTable, 4> kCrcTables = crc_tables();

}  // namespace detail

// CRC of what `crc` covers and these bytes behind it; 0 covers nothing. Little-endian machines
// only.
inline uint32_t crc32(uint32_t crc, const void* data, size_t count) {
    const auto& tables = detail::kCrcTables;
    const auto* bytes = static_cast<const uint8_t*>(data);
    crc = ~crc;
    for (; count >= 4; count -= 4, bytes += 4) {
        uint32_t word = 0;
        std::memcpy(&word, bytes, sizeof word);
        word ^= crc;
        crc = tables[3][word & 0xFFU] ^ tables[2][(word >> 8) & 0xFFU] ^
              tables[1][(word >> 16) & 0xFFU] ^ tables[0][word >> 24];
    }
    for (; count != 0; --count, ++bytes) crc = (crc >> 8) ^ tables[0][(crc ^ *bytes) & 0xFFU];
    return ~crc;
}

// The same of these bytes alone, bit by bit: for what is rare, in images that have no room for the
// tables.
inline uint32_t crc32_bitwise(const void* data, size_t count) {
    const auto* bytes = static_cast<const uint8_t*>(data);
    uint32_t crc = ~0U;
    for (size_t i = 0; i < count; ++i) {
        crc ^= bytes[i];
        for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1) ^ ((crc & 1U) != 0 ? 0xEDB88320U : 0U);
    }
    return ~crc;
}

}  // namespace stator
