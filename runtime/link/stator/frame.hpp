// Frames of the link between a vehicle and a person's terminal: docs/link.md.
//
// A body and its CRC-32 are coded without zeros (Cheshire and Baker, "Consistent Overhead Byte
// Stuffing", 1999) and end with one. So whatever came before, the byte behind a zero begins a
// frame.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>

#include "stator/crc32.hpp"

namespace stator {

inline constexpr size_t kCrcBytes = 4;
// Of a body of `count` bytes: its CRC, a byte more for each 254, the first and the last.
constexpr size_t frame_bytes(size_t count) {
    return count + kCrcBytes + (count + kCrcBytes) / 254 + 2;
}

// Writes the frame of `count` bytes of `body`, behind which there is room for the CRC. `frame` has
// room for `frame_bytes(count)`. Returns its length.
inline size_t write_frame(uint8_t* body, size_t count, uint8_t* frame) {
    const uint32_t crc = crc32_bitwise(body, count);
    std::memcpy(body + count, &crc, sizeof crc);
    size_t code_at = 0;  // where the length of the present run without zeros stands
    size_t end = 1;
    for (size_t i = 0; i < count + kCrcBytes; ++i) {
        if (end - code_at == 255) {
            frame[code_at] = 255;
            code_at = end++;
        }
        if (body[i] == 0) {
            frame[code_at] = static_cast<uint8_t>(end - code_at);
            code_at = end++;
        } else {
            frame[end++] = body[i];
        }
    }
    frame[code_at] = static_cast<uint8_t>(end - code_at);
    frame[end++] = 0;
    return end;
}

// Finds the frames in a stream of bytes. What is damaged, cut or longer than `kMax` is left out.
template <size_t kMax>
class FrameReader {
  public:
    // True if the byte ends a whole frame, whose body then stands until the next call.
    bool take(uint8_t byte) {
        if (byte != 0) {
            add(byte);
            return false;
        }
        const bool is_whole = !is_broken_ && left_ == 0 && size_ >= kCrcBytes && is_sound();
        count_ = is_whole ? size_ - kCrcBytes : 0;
        size_ = 0;
        left_ = 0;
        is_broken_ = false;
        owes_zero_ = false;
        return is_whole;
    }
    const uint8_t* body() const { return body_.data(); }
    size_t count() const { return count_; }

  private:
    void add(uint8_t byte) {
        if (left_ != 0) {
            put(byte);
            --left_;
            return;
        }
        if (owes_zero_) put(0);
        left_ = static_cast<uint8_t>(byte - 1);
        owes_zero_ = byte != 255;
    }
    void put(uint8_t byte) {
        if (size_ == body_.size()) {
            is_broken_ = true;
        } else {
            body_[size_++] = byte;
        }
    }
    bool is_sound() const {
        uint32_t crc = 0;
        std::memcpy(&crc, body_.data() + size_ - kCrcBytes, sizeof crc);
        return crc == crc32_bitwise(body_.data(), size_ - kCrcBytes);
    }

    std::array<uint8_t, kMax + kCrcBytes> body_{};
    size_t size_ = 0;
    size_t count_ = 0;
    uint8_t left_ = 0;  // of the present run
    bool owes_zero_ = false;
    bool is_broken_ = false;
};

}  // namespace stator
