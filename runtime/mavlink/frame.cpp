// A frame of MAVLink 2.
#include "stator/mavlink/frame.hpp"

namespace stator::mav {

void copy_payload(std::span<uint8_t> message, std::span<const uint8_t> payload) {
    const std::size_t length = std::min(message.size(), payload.size());
    std::fill(std::copy_n(payload.begin(), length, message.begin()), message.end(), uint8_t{0});
}

// A payload's zeros at its end do not travel, but for the first byte.
void FrameBytes::put(const Kind& kind, std::span<const uint8_t> payload, uint8_t sequence,
                     Address source, const Signed* as) {
    std::size_t length = payload.size();
    while (length > 1 && payload[length - 1] == 0) --length;
    const std::array<uint8_t, kHeaderBytes> header{kStart,
                                                   static_cast<uint8_t>(length),
                                                   as == nullptr ? uint8_t{0} : kIsSigned,
                                                   0,
                                                   sequence,
                                                   source.system,
                                                   source.component,
                                                   static_cast<uint8_t>(kind.id),
                                                   static_cast<uint8_t>(kind.id >> 8),
                                                   static_cast<uint8_t>(kind.id >> 16)};
    std::copy(header.begin(), header.end(), bytes_.begin());
    std::copy_n(payload.begin(), length, bytes_.begin() + kHeaderBytes);
    const std::size_t end = kHeaderBytes + length;
    const uint16_t crc =
        crc16(crc16(kCrcSeed, std::span(bytes_).first(end).subspan(1)), kind.crc_extra);
    bytes_[end] = static_cast<uint8_t>(crc);
    bytes_[end + 1] = static_cast<uint8_t>(crc >> 8);
    size_ = end + kCrcBytes;
    if (as == nullptr) return;
    std::fill_n(bytes_.begin() + static_cast<std::ptrdiff_t>(size_), kSignatureBytes, uint8_t{0});
    bytes_[size_++] = as->link;
    for (unsigned i = 0; i < 6; ++i) bytes_[size_ + i] = static_cast<uint8_t>(as->time >> 8 * i);
    size_ += kSignatureBytes - 1;
}

}  // namespace stator::mav
