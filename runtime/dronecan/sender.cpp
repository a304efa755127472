// Cuts one transfer into frames.
#include "stator/dronecan/sender.hpp"

#include "stator/dronecan/crc.hpp"

namespace stator::dronecan {

namespace {

constexpr std::size_t kPayloadBytes = kMaxFrameBytes - 1;

}  // namespace

void FrameCutter::begin(const Header& header, uint8_t transfer_id, uint16_t crc_seed,
                        std::span<uint8_t> bytes) {
    const std::span<const uint8_t> payload = bytes.subspan(kCrcBytes);
    left_ = payload;
    if (payload.size() > kPayloadBytes) {
        const uint16_t crc = crc16(crc_seed, payload);
        bytes[0] = static_cast<uint8_t>(crc);
        bytes[1] = static_cast<uint8_t>(crc >> 8);
        left_ = bytes;
    }
    id_ = to_id(header);
    tail_ = static_cast<uint8_t>(Tail::kStart | (transfer_id & Tail::kTransferId));
    busy_ = true;
}

bool FrameCutter::next(Frame& frame) {
    if (!busy_) return false;
    const std::size_t count = left_.size() < kPayloadBytes ? left_.size() : kPayloadBytes;
    frame = {.id = id_, .length = static_cast<uint8_t>(count + 1)};
    for (std::size_t i = 0; i < count; ++i) frame.data[i] = left_[i];
    left_ = left_.subspan(count);
    busy_ = !left_.empty();
    frame.data[count] = busy_ ? tail_ : static_cast<uint8_t>(tail_ | Tail::kEnd);
    tail_ = static_cast<uint8_t>((tail_ ^ Tail::kToggle) & ~Tail::kStart);
    return true;
}

}  // namespace stator::dronecan
