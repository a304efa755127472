// A frame of MAVLink 2.
#include "stator/mavlink/frame.hpp"

namespace stator::mav {

// A payload's zeros at its end do not travel, but for the first byte.
void FrameBytes::finish(uint32_t id, uint8_t crc_extra, std::size_t length, uint8_t sequence,
                        Address source) {
    while (length > 1 && bytes_[kHeaderBytes + length - 1] == 0) --length;
    const std::array<uint8_t, kHeaderBytes> header{kStart,
                                                   static_cast<uint8_t>(length),
                                                   0,
                                                   0,
                                                   sequence,
                                                   source.system,
                                                   source.component,
                                                   static_cast<uint8_t>(id),
                                                   static_cast<uint8_t>(id >> 8),
                                                   static_cast<uint8_t>(id >> 16)};
    std::copy(header.begin(), header.end(), bytes_.begin());
    const std::size_t end = kHeaderBytes + length;
    const uint16_t crc = crc16(crc16(kCrcSeed, std::span(bytes_).first(end).subspan(1)), crc_extra);
    bytes_[end] = static_cast<uint8_t>(crc);
    bytes_[end + 1] = static_cast<uint8_t>(crc >> 8);
    size_ = end + kCrcBytes;
}

}  // namespace stator::mav
