// The identifier of a frame.
#include "stator/dronecan/frame.hpp"

namespace stator::dronecan {

namespace {

constexpr uint32_t kServiceBit = 0x80;
constexpr uint32_t kRequestBit = 0x8000;

}  // namespace

uint32_t to_id(const Header& header) {
    const uint32_t common =
        (static_cast<uint32_t>(header.priority & 0x1F) << 24) | (header.source & 0x7FU);
    if (header.kind != DataType::Kind::kMessage) {
        const uint32_t request = header.kind == DataType::Kind::kRequest ? kRequestBit : 0;
        return common | kServiceBit | request | ((header.type_id & 0xFFU) << 16) |
               ((header.destination & 0x7FU) << 8);
    }
    if (header.source != 0) return common | (static_cast<uint32_t>(header.type_id) << 8);
    return common | ((header.discriminator & 0x3FFFU) << 10) | ((header.type_id & 3U) << 8);
}

Header from_id(uint32_t id) {
    Header header{.priority = static_cast<uint8_t>((id >> 24) & 0x1F),
                  .source = static_cast<uint8_t>(id & 0x7F)};
    if ((id & kServiceBit) != 0) {
        header.kind =
            (id & kRequestBit) != 0 ? DataType::Kind::kRequest : DataType::Kind::kResponse;
        header.type_id = static_cast<uint8_t>(id >> 16);
        header.destination = static_cast<uint8_t>((id >> 8) & 0x7F);
    } else if (header.source != 0) {
        header.type_id = static_cast<uint16_t>(id >> 8);
    } else {
        header.type_id = static_cast<uint16_t>((id >> 8) & 3);
        header.discriminator = static_cast<uint16_t>((id >> 10) & 0x3FFF);
    }
    return header;
}

}  // namespace stator::dronecan
