// Fields of a message and their bytes: little-endian, without gaps. Generated messages say in which
// order.
#pragma once

#include <array>
#include <bit>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>

namespace stator::mav {

// The unsigned integer of a type's size.
template <class Value>
using BitsOf = std::conditional_t<
    sizeof(Value) == 1, uint8_t,
    std::conditional_t<sizeof(Value) == 2, uint16_t,
                       std::conditional_t<sizeof(Value) == 4, uint32_t, uint64_t>>>;

// Writes fields into storage that holds them all.
class ToBytes {
  public:
    explicit ToBytes(std::span<uint8_t> bytes) : bytes_(bytes) {}

    template <class Value>
    requires std::is_arithmetic_v<Value>
    void field(const Value& value) {
        auto bits = std::bit_cast<BitsOf<Value>>(value);
        for (std::size_t i = 0; i < sizeof(Value); ++i) {
            bytes_[at_++] = static_cast<uint8_t>(bits);
            if constexpr (sizeof(Value) > 1) bits = static_cast<BitsOf<Value>>(bits >> 8);
        }
    }
    template <class Value, std::size_t kCount>
    void field(const std::array<Value, kCount>& values) {
        for (const Value& value : values) field(value);
    }

  private:
    std::span<uint8_t> bytes_;
    std::size_t at_ = 0;
};

// Reads fields. What lies behind the end reads as zero: senders leave out zeros at the end.
class FromBytes {
  public:
    explicit FromBytes(std::span<const uint8_t> bytes) : bytes_(bytes) {}

    template <class Value>
    requires std::is_arithmetic_v<Value>
    void field(Value& value) {
        BitsOf<Value> bits = 0;
        for (std::size_t i = 0; i < sizeof(Value); ++i, ++at_) {
            const BitsOf<Value> byte = at_ < bytes_.size() ? bytes_[at_] : uint8_t{0};
            bits = static_cast<BitsOf<Value>>(bits | (byte << (8 * i)));
        }
        value = std::bit_cast<Value>(bits);
    }
    template <class Value, std::size_t kCount>
    void field(std::array<Value, kCount>& values) {
        for (Value& value : values) field(value);
    }

  private:
    std::span<const uint8_t> bytes_;
    std::size_t at_ = 0;
};

// Any payload decodes: one of an older or newer definition, too.
template <class Message>
Message decode(std::span<const uint8_t> payload) {
    Message message;
    FromBytes bytes(payload);
    Message::visit(bytes, message);
    return message;
}

}  // namespace stator::mav
