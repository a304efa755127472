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
#include "stator/mavlink/known.hpp"

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

// A received frame; its bytes lie in the parser until the parser takes more.
struct Frame {
    uint32_t id = 0;
    Address source;
    uint8_t sequence = 0;
    bool is_signed = false;
    const Known* known = nullptr;    // null: not a message that we know, and the CRC is not checked
    std::span<const uint8_t> bytes;  // all of it
    std::span<const uint8_t> payload;
};

// Who a frame is for. Zeros are for all, and so is what does not say it.
inline Address target_of(const Frame& frame) {
    if (frame.known == nullptr || frame.known->target == Known::kNoTarget) return {};
    const std::size_t at = frame.known->target & static_cast<uint8_t>(~Known::kHasComponent);
    const bool has_component = (frame.known->target & Known::kHasComponent) != 0;
    const auto byte = [&](std::size_t i) {
        return i < frame.payload.size() ? frame.payload[i] : uint8_t{0};
    };
    return {.system = byte(at), .component = has_component ? byte(at + 1) : uint8_t{0}};
}

// The end of a signed frame but for its hash, which follows from a key: see gate.hpp.
struct Signed {
    uint8_t link = 0;
    uint64_t time = 0;  // 10 us since 2015; no two frames of a link have the same
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
    // `as`: the frame is signed, once its hash is there.
    void put(const Kind& kind, std::span<const uint8_t> payload, uint8_t sequence, Address source,
             const Signed* as = nullptr);

  private:
    std::array<uint8_t, kMaxFrameBytes> bytes_{};
    std::size_t size_ = 0;
};

}  // namespace stator::mav
