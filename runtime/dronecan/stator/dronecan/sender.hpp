// Cuts one transfer into frames.
#pragma once

#include "stator/dronecan/frame.hpp"

namespace stator::dronecan {

// Holds one transfer while its frames go out. `begin` a transfer, then take frames until `next`
// says false: 1 frame for up to 7 bytes, else one for each 7 bytes of payload and checksum.
template <unsigned kMaxBytes>
class Sender;

class FrameCutter {
  public:
    bool is_busy() const { return busy_; }
    // Writes the next frame; false, and nothing written, if there is none left.
    bool next(Frame& frame);

  protected:
    static constexpr unsigned kCrcBytes = 2;

    // `bytes`: room for the checksum, then the payload. Stays in use until the last frame.
    void begin(const Header& header, uint8_t transfer_id, uint16_t crc_seed,
               std::span<uint8_t> bytes);

  private:
    std::span<const uint8_t> left_;
    uint32_t id_ = 0;
    uint8_t tail_ = 0;
    bool busy_ = false;
};

template <unsigned kMaxBytes>
class Sender : public FrameCutter {
  public:
    Sender() = default;
    Sender(const Sender&) = delete;
    Sender& operator=(const Sender&) = delete;

    // What was not yet sent of an earlier transfer is dropped.
    template <class Message>
    void begin(Header header, uint8_t transfer_id, const Message& message) {
        static_assert(Message::kType.most_bytes <= kMaxBytes);
        header.kind = Message::kType.kind;
        header.type_id = Message::kType.id;
        const std::span<uint8_t> payload = std::span(bytes_).subspan(kCrcBytes);
        const std::size_t length = encode(message, payload);
        FrameCutter::begin(header, transfer_id, Message::kType.crc_seed,
                           std::span(bytes_).first(kCrcBytes + length));
    }

  private:
    std::array<uint8_t, kCrcBytes + kMaxBytes> bytes_{};
};

}  // namespace stator::dronecan
