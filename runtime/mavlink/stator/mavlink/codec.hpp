// Fields of a message and their bytes: little-endian, without gaps. Generated messages say in which
// order. The fields of most messages lie in a struct as they travel (`kIsPlain`): those are copied
// as a whole.
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

// What a message is on its way, besides its fields.
struct Kind {
    uint32_t id;
    uint8_t crc_extra;
    uint8_t length;
};

template <class Message>
inline constexpr Kind kKindOf{Message::kId, Message::kCrcExtra, Message::kLength};

// Fills `message` from a payload; what lies behind its end reads as zero.
void copy_payload(std::span<uint8_t> message, std::span<const uint8_t> payload);

// Any payload decodes: one of an older or newer definition, too. What lies behind its end reads as
// zero: senders leave out zeros at the end.
template <class Message>
Message decode(std::span<const uint8_t> payload) {
    Message message;
    if constexpr (Message::kIsPlain) {
        copy_payload({reinterpret_cast<uint8_t*>(&message), Message::kLength}, payload);
    } else {
        std::array<uint8_t, Message::kLength> bytes;
        copy_payload(bytes, payload);
        FromBytes from(bytes);
        Message::visit(from, message);
    }
    return message;
}

// Calls `use` with the payload of a message, in its whole length.
template <class Message, class Use>
auto with_payload(const Message& message, Use use) {
    if constexpr (Message::kIsPlain) {
        return use(std::span(reinterpret_cast<const uint8_t*>(&message), Message::kLength));
    } else {
        std::array<uint8_t, Message::kLength> bytes;
        ToBytes out(bytes);
        Message::visit(out, message);
        return use(std::span<const uint8_t>(bytes));
    }
}

}  // namespace stator::mav
