// What generated codecs are made of. Each type has `visit`, which walks its fields with a BitWriter
// or a BitReader: one description of the layout for both directions.
//
// A field's bytes travel least significant first, each byte's bits most significant first. An array
// of varying length that ends a message has no length field: it takes what is left.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>

#include "stator/dronecan/float16.hpp"

namespace stator::dronecan {

// A type that travels by itself.
struct DataType {
    enum class Kind : uint8_t { kMessage, kRequest, kResponse };
    Kind kind;
    uint16_t id;
    uint16_t crc_seed;
    uint16_t most_bytes;  // of its payload
};

// An array of varying length in storage of fixed size.
template <class Item, unsigned kMax>
struct Array {
    static constexpr unsigned kCapacity = kMax;
    std::array<Item, kMax> items{};
    uint16_t count = 0;

    // What is beyond the capacity is left out.
    template <class Container>
    void assign(const Container& container) {
        count = 0;
        for (const auto& item : container) {
            if (count < kMax) items[count++] = static_cast<Item>(item);
        }
    }
    std::span<const Item> view() const { return {items.data(), count}; }
    bool operator==(const Array& other) const {
        return std::equal(items.begin(), items.begin() + count, other.items.begin(),
                          other.items.begin() + other.count);
    }
};

// Writes fields into zeroed storage. Values beyond a field's range become its least or most.
class BitWriter {
  public:
    explicit BitWriter(std::span<uint8_t> bytes) : bytes_(bytes) {}

    std::size_t used_bytes() const { return (position_ + 7) / 8; }

    void skip(unsigned bits) { put(0, bits); }
    void boolean(bool value) { put(value ? 1 : 0, 1); }
    void truncated_unsigned(uint64_t value, unsigned bits) { put(value, bits); }
    void saturated_unsigned(uint64_t value, unsigned bits) {
        const uint64_t most = bits == 64 ? UINT64_MAX : (uint64_t{1} << bits) - 1;
        put(value > most ? most : value, bits);
    }
    void saturated_signed(int64_t value, unsigned bits) {
        const int64_t most = INT64_MAX >> (64 - bits);
        const int64_t least = -most - 1;
        const int64_t kept = value > most ? most : value < least ? least : value;
        put(static_cast<uint64_t>(kept), bits);
    }
    void float16(float value) { put(to_float16(value), 16); }
    void float32(float value) {
        const uint32_t bits = std::bit_cast<uint32_t>(value);
        const uint32_t magnitude = bits & 0x7FFFFFFF;
        // Not a number in its one form; infinite as the largest number.
        if (magnitude > 0x7F800000) return put(0x7FC00000, 32);
        put(magnitude == 0x7F800000 ? bits - 1 : bits, 32);
    }
    template <class Tag>
    void tag(Tag tag, unsigned bits, unsigned) {
        put(static_cast<uint64_t>(tag), bits);
    }
    template <class Items, class Visit>
    void array(const Items& array, unsigned length_bits, bool to_the_end, Visit visit) {
        const uint16_t count = array.count < Items::kCapacity ? array.count : Items::kCapacity;
        if (!to_the_end) put(count, length_bits);
        for (unsigned i = 0; i < count; ++i) visit(array.items[i]);
    }

  private:
    void put(uint64_t value, unsigned bits) {
        for (; bits > 8; bits -= 8, value >>= 8) put_chunk(static_cast<unsigned>(value & 0xFF), 8);
        put_chunk(static_cast<unsigned>(value) & ((1U << bits) - 1), bits);
    }
    void put_chunk(unsigned chunk, unsigned bits) {
        const unsigned window = chunk << (16 - bits - position_ % 8);
        const std::size_t first = position_ / 8;
        position_ += bits;
        if (first < bytes_.size()) bytes_[first] |= static_cast<uint8_t>(window >> 8);
        if (first + 1 < bytes_.size()) bytes_[first + 1] |= static_cast<uint8_t>(window);
    }

    std::span<uint8_t> bytes_;
    std::size_t position_ = 0;  // bits
};

// Reads fields. After a field that is not there, or an impossible length or tag, everything reads
// as zero and `is_good` stays false. Never reads past the end.
class BitReader {
  public:
    explicit BitReader(std::span<const uint8_t> bytes) : bytes_(bytes), left_(8 * bytes.size()) {}

    // True if all fields were there and nothing but padding is left.
    bool is_good() const { return good_ && left_ < 8; }

    void skip(unsigned bits) { static_cast<void>(take(bits)); }
    void boolean(bool& value) { value = take(1) != 0; }
    template <class Value>
    void truncated_unsigned(Value& value, unsigned bits) {
        value = static_cast<Value>(take(bits));
    }
    template <class Value>
    void saturated_unsigned(Value& value, unsigned bits) {
        value = static_cast<Value>(take(bits));
    }
    template <class Value>
    void saturated_signed(Value& value, unsigned bits) {
        // Up to the top and down again brings the sign along.
        value = static_cast<Value>(static_cast<int64_t>(take(bits) << (64 - bits)) >> (64 - bits));
    }
    void float16(float& value) { value = from_float16(static_cast<uint16_t>(take(16))); }
    void float32(float& value) { value = std::bit_cast<float>(static_cast<uint32_t>(take(32))); }
    template <class Tag>
    void tag(Tag& tag, unsigned bits, unsigned count) {
        const uint64_t value = take(bits);
        if (value >= count) fail();
        tag = static_cast<Tag>(good_ ? value : 0);
    }
    template <class Items, class Visit>
    void array(Items& array, unsigned length_bits, bool to_the_end, Visit visit) {
        array.count = 0;
        const uint64_t count = to_the_end ? Items::kCapacity : take(length_bits);
        if (count > Items::kCapacity) fail();
        while (good_ && array.count < count && (!to_the_end || left_ >= 8)) {
            visit(array.items[array.count]);
            if (good_) ++array.count;
        }
    }

  private:
    void fail() {
        good_ = false;
        left_ = 0;
    }
    uint64_t take(unsigned bits) {
        if (bits > left_) fail();
        if (!good_) return 0;
        uint64_t value = 0;
        unsigned shift = 0;
        for (; bits > 8; bits -= 8, shift += 8) value |= uint64_t{take_chunk(8)} << shift;
        return value | uint64_t{take_chunk(bits)} << shift;
    }
    unsigned take_chunk(unsigned bits) {
        const std::size_t position = 8 * bytes_.size() - left_;
        const std::size_t first = position / 8;
        left_ -= bits;
        const unsigned low = first + 1 < bytes_.size() ? bytes_[first + 1] : 0;
        const unsigned window = (static_cast<unsigned>(bytes_[first]) << 8) | low;
        return (window >> (16 - bits - position % 8)) & ((1U << bits) - 1);
    }

    std::span<const uint8_t> bytes_;
    std::size_t left_;  // bits
    bool good_ = true;
};

// Returns the length of the payload; `bytes` holds `most_bytes` of the type or more.
template <class Message>
[[nodiscard]] std::size_t encode(const Message& message, std::span<uint8_t> bytes) {
    for (uint8_t& byte : bytes) byte = 0;
    BitWriter writer(bytes);
    Message::visit(writer, message, true);
    return writer.used_bytes();
}

// False for a payload that is none of this type; `message` is then of no use.
template <class Message>
[[nodiscard]] bool decode(std::span<const uint8_t> bytes, Message& message) {
    BitReader reader(bytes);
    Message::visit(reader, message, true);
    return reader.is_good();
}

}  // namespace stator::dronecan
