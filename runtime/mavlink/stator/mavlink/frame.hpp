// A frame of MAVLink 2: https://mavlink.io/en/guide/serialization.html.
//
//     0xFD length incompat compat sequence system component id(3) payload(length) crc(2)
//     [signature(13)]
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "stator/mavlink/codec.hpp"
#include "stator/mavlink/crc.hpp"

namespace stator::mav {

inline constexpr uint8_t kStart = 0xFD;
inline constexpr std::size_t kHeaderBytes = 10;
inline constexpr std::size_t kCrcBytes = 2;
inline constexpr std::size_t kSignatureBytes = 13;
inline constexpr std::size_t kMaxPayload = 255;
inline constexpr std::size_t kMaxFrameBytes =
    kHeaderBytes + kMaxPayload + kCrcBytes + kSignatureBytes;
inline constexpr uint8_t kIsSigned = 1;  // of the incompatibility flags, the only one that there is

// Where a frame comes from.
struct Address {
    uint8_t system = 0;
    uint8_t component = 0;
    bool operator==(const Address&) const = default;
};

// A received frame; its payload lies in the parser until the parser takes more bytes.
struct Frame {
    uint32_t id = 0;
    Address source;
    uint8_t sequence = 0;
    bool is_signed = false;
    std::span<const uint8_t> payload;
};

// Room for one frame to be sent.
class FrameBytes {
  public:
    std::span<const uint8_t> bytes() const { return std::span(bytes_).first(size_); }

    template <class Message>
    void put(const Message& message, uint8_t sequence, Address source) {
        with_payload(message, [&](std::span<const uint8_t> payload) {
            put(kKindOf<Message>, payload, sequence, source);
        });
    }
    void put(const Kind& kind, std::span<const uint8_t> payload, uint8_t sequence, Address source);

  private:
    std::array<uint8_t, kHeaderBytes + kMaxPayload + kCrcBytes> bytes_{};
    std::size_t size_ = 0;
};

}  // namespace stator::mav
