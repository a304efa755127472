// The file of all parameters that ground stations fetch at once: ArduPilot's `@PARAM/param.pck`.
// It begins with a head; then come the parameters in the order of their ids, each without the
// letters that it shares with the one before. All numbers are little-endian.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <span>
#include <string_view>

#include "stator/parameters.hpp"

namespace stator::parameter_pack {

inline constexpr unsigned kHeadBytes = 6;
inline constexpr unsigned kMaxIdBytes = 16;
// Padding, type, lengths, letters, value, default.
inline constexpr unsigned kMaxEntryBytes = 3 + 2 + kMaxIdBytes + 4 + 4;

struct Entry {
    std::string_view before;  // id of the one before in this file; empty for the first
    std::string_view id;
    ParameterType type;
    ParameterBits value;
    ParameterBits standard;
};

// 0: `out` is too short.
inline unsigned put_head(std::span<uint8_t> out, uint16_t entries, uint16_t all,
                         bool with_defaults) {
    constexpr uint16_t kMagic = 0x671B;
    if (out.size() < kHeadBytes) return 0;
    const uint16_t head[3]{static_cast<uint16_t>(kMagic + (with_defaults ? 1 : 0)), entries, all};
    std::memcpy(out.data(), head, kHeadBytes);
    return kHeadBytes;
}

// Writes the entry that begins at `place` of the file, and says how long it is; 0: `out` is too
// short. Readers fetch blocks of `block_bytes` and may fetch one twice, so no value lies in two: in
// front of an entry there may be zeros. A default follows only where it differs from the value.
inline unsigned put_entry(std::span<uint8_t> out, uint32_t place, uint32_t block_bytes,
                          const Entry& entry, bool with_defaults) {
    constexpr uint8_t kInt32 = 3;
    constexpr uint8_t kFloat = 4;
    constexpr uint8_t kHasDefault = 0x10;
    constexpr uint32_t kValueBytes = sizeof(ParameterBits);
    const std::string_view id = entry.id.substr(0, kMaxIdBytes);
    const size_t most_shared = std::min({entry.before.size(), id.size() - 1, size_t{15}});
    size_t shared = 0;
    while (shared < most_shared && entry.before[shared] == id[shared]) ++shared;
    const std::string_view letters = id.substr(shared);
    const uint32_t value_at = place + 2 + static_cast<uint32_t>(letters.size());
    const uint32_t in_block = block_bytes == 0 ? 0 : value_at % block_bytes;
    const uint32_t padding = block_bytes > kValueBytes && in_block + kValueBytes > block_bytes
                                 ? block_bytes - in_block
                                 : 0;
    const bool has_default = with_defaults && entry.standard != entry.value;
    const size_t bytes = padding + 2 + letters.size() + kValueBytes * (has_default ? 2 : 1);
    if (id.empty() || bytes > out.size()) return 0;
    uint8_t* at = std::fill_n(out.data(), padding, uint8_t{0});
    *at++ = static_cast<uint8_t>((entry.type == ParameterType::kFloat ? kFloat : kInt32) |
                                 (has_default ? kHasDefault : 0));
    *at++ = static_cast<uint8_t>(shared | (letters.size() - 1) << 4);
    at = std::copy(letters.begin(), letters.end(), at);
    std::memcpy(at, &entry.value, kValueBytes);
    if (has_default) std::memcpy(at + kValueBytes, &entry.standard, kValueBytes);
    return static_cast<unsigned>(bytes);
}

}  // namespace stator::parameter_pack
