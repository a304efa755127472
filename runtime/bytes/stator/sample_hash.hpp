// A hash of 32 bits of a sample, by which a replay compares: a multiplication and two exclusive ors
// for each word. Of samples that differ in one word only, none have the same hash, as each step can
// be undone; of others, one in 2^32. codegen/stator/flight/recording.py has it again.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>

namespace stator {

namespace detail {

[[gnu::always_inline]] inline uint32_t hash_on(uint32_t hash, const std::byte* bytes) {
    uint32_t word = 0;
    std::memcpy(&word, bytes, sizeof word);
    hash = (hash ^ word) * 0x9E3779B1U;  // odd, with its bits spread: 2^32 by the golden ratio
    return hash ^ (hash >> 15);
}

}  // namespace detail

// `count`: a multiple of 4, as of every message. Little-endian machines only.
inline uint32_t sample_hash(const void* sample, size_t count) {
    const auto* bytes = static_cast<const std::byte*>(sample);
    uint32_t hash = 0;
    for (const std::byte* end = bytes + count; bytes != end; bytes += sizeof(uint32_t)) {
        hash = detail::hash_on(hash, bytes);
    }
    return hash;
}
// The same of a message: mostly without a loop.
template <size_t kBytes>
[[gnu::always_inline]] inline uint32_t sample_hash(const void* message) {
    const auto* bytes =
        static_cast<const std::byte*>(__builtin_assume_aligned(message, alignof(uint64_t)));
    uint32_t hash = 0;
#pragma GCC unroll 16
    for (size_t i = 0; i < kBytes; i += sizeof(uint32_t)) hash = detail::hash_on(hash, bytes + i);
    return hash;
}

}  // namespace stator
