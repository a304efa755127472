// Signatures of frames: https://mavlink.io/en/guide/message_signing.html.
//
// A signed frame ends with: link(1) time(6) hash(6). The hash is the first bytes of the SHA-256 of
// the key and of all of the frame before it.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>

#include "stator/mavlink/frame.hpp"
#include "stator/mavlink/sha256.hpp"

namespace stator::mav {

inline constexpr std::size_t kKeyBytes = 32;
inline constexpr std::size_t kHashBytes = 6;
inline constexpr std::size_t kTimeBytes = kSignatureBytes - kHashBytes - 1;
inline constexpr std::size_t kFingerprintBytes = 8;

using SigningKeyBytes = std::array<uint8_t, kKeyBytes>;
// What may be told of a key: the first bytes of its SHA-256.
using Fingerprint = std::array<uint8_t, kFingerprintBytes>;

inline Fingerprint fingerprint_of(const SigningKeyBytes& key) {
    Sha256 sha;
    sha.add(key);
    const auto digest = sha.finish();
    Fingerprint result{};
    std::copy_n(digest.begin(), result.size(), result.begin());
    return result;
}

// Without the link, of a frame that is signed.
inline uint64_t time_of(std::span<const uint8_t> signed_frame) {
    const auto bytes = signed_frame.last(kHashBytes + kTimeBytes);
    uint64_t time = 0;
    for (std::size_t i = kTimeBytes; i-- > 0;) time = time << 8 | bytes[i];
    return time;
}
inline uint8_t link_of(std::span<const uint8_t> signed_frame) {
    return signed_frame[signed_frame.size() - kSignatureBytes];
}

}  // namespace stator::mav
