// Fields of a message and their bytes: little-endian, without gaps. Generated messages say in which
// order.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <span>

namespace stator::mav {

// As the processors of all boards have them.
static_assert(std::endian::native == std::endian::little);

// Writes fields into storage that holds them all. Arrays are as long as their items.
class ToBytes {
  public:
    explicit ToBytes(std::span<uint8_t> bytes) : at_(bytes.data()) {}

    template <class Value>
    void field(const Value& value) {
        std::memcpy(at_, &value, sizeof value);
        at_ += sizeof value;
    }

  private:
    uint8_t* at_;
};

// Reads fields from storage that holds them all.
class FromBytes {
  public:
    explicit FromBytes(std::span<const uint8_t> bytes) : at_(bytes.data()) {}

    template <class Value>
    void field(Value& value) {
        std::memcpy(&value, at_, sizeof value);
        at_ += sizeof value;
    }

  private:
    const uint8_t* at_;
};

// Any payload decodes: one of an older or newer definition, too. What lies behind its end reads as
// zero: senders leave out zeros at the end.
template <class Message>
Message decode(std::span<const uint8_t> payload) {
    std::array<uint8_t, Message::kLength> bytes{};
    std::copy_n(payload.begin(), std::min(payload.size(), bytes.size()), bytes.begin());
    Message message;
    FromBytes from(bytes);
    Message::visit(from, message);
    return message;
}

}  // namespace stator::mav
