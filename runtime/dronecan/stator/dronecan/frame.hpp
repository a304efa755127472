// One CAN frame of a transfer: what its identifier and its last byte say.
//
// The 29 bits of the identifier, from the top: priority (5, 0 is most urgent), then for a message
// its type (16), 0, sender (7); for a service its type (8), request or response (1), receiver (7),
// 1, sender (7). A node without an id sends as 0 and has only the two lowest bits of the type,
// behind 14 that tell it from others. The last byte: start of transfer, end of transfer, toggle,
// transfer id (5).
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "stator/dronecan/codec.hpp"

namespace stator::dronecan {

inline constexpr unsigned kMaxFrameBytes = 8;
inline constexpr uint8_t kMaxNodeId = 127;
inline constexpr uint8_t kTransferIds = 32;

// An extended data frame.
struct Frame {
    uint32_t id = 0;
    uint8_t length = 0;
    std::array<uint8_t, kMaxFrameBytes> data{};

    bool operator==(const Frame&) const = default;
};

struct Header {
    DataType::Kind kind = DataType::Kind::kMessage;
    uint8_t priority = 16;
    uint16_t type_id = 0;
    uint8_t source = 0;          // 0: a node that has no id yet
    uint8_t destination = 0;     // of services only
    uint16_t discriminator = 0;  // of nodes without id only

    bool operator==(const Header&) const = default;
};

[[nodiscard]] uint32_t to_id(const Header& header);
[[nodiscard]] Header from_id(uint32_t id);

struct Tail {
    static constexpr uint8_t kStart = 0x80;
    static constexpr uint8_t kEnd = 0x40;
    static constexpr uint8_t kToggle = 0x20;
    static constexpr uint8_t kTransferId = 0x1F;
};

}  // namespace stator::dronecan
