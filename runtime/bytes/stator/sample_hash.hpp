// A hash of 32 bits of a sample, by which a replay compares: a multiplication and two exclusive ors
// for each word. Of samples that differ in one word only, none have the same hash, as each step can
// be undone; of others, one in 2^32. codegen/stator/flight/recording.py has it again.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>

namespace stator {

// `count`: a multiple of 4, as of every message. Little-endian machines only.
inline uint32_t sample_hash(const void* sample, size_t count) {
    const auto* bytes = static_cast<const std::byte*>(sample);
    uint32_t hash = 0;
    for (const std::byte* end = bytes + count; bytes != end; bytes += sizeof(uint32_t)) {
        uint32_t word = 0;
        std::memcpy(&word, bytes, sizeof word);
        hash = (hash ^ word) * 0x9E3779B1U;  // odd, with its bits spread: 2^32 by the golden ratio
        hash ^= hash >> 15;
    }
    return hash;
}

}  // namespace stator
