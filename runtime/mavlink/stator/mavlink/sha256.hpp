// SHA-256 (FIPS 180-4).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace stator::mav {

// Takes bytes piece by piece. 64 of them cost about 2,500 instructions of a Cortex-M4 and 112 bytes
// of stack; nothing of it depends on their values.
class Sha256 {
  public:
    using Digest = std::array<uint8_t, 32>;

    void add(std::span<const uint8_t> bytes);
    // Of all that was added; then it is used up.
    Digest finish();

  private:
    static constexpr std::size_t kBlock = 64;

    void take_block();

    std::array<uint32_t, 8> state_{0x6A09E667, 0xBB67AE85, 0x3C6EF372, 0xA54FF53A,
                                   0x510E527F, 0x9B05688C, 0x1F83D9AB, 0x5BE0CD19};
    std::array<uint8_t, kBlock> block_{};
    uint32_t size_ = 0;  // all bytes; no frame is longer than 512 MB
};

}  // namespace stator::mav
