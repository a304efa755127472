// Finds the frames in a stream of bytes.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "stator/mavlink/frame.hpp"
#include "stator/mavlink/known.hpp"

namespace stator::mav {

// What a parser has seen since the start.
struct ParserCounters {
    uint32_t frames = 0;
    uint32_t damaged = 0;  // plausible heads of messages that we know, whose checksum was wrong
    uint32_t skipped = 0;  // bytes that belong to no good frame
};

// A start byte inside other data looks like a frame and hides what follows. So nothing is thrown
// away but the false start itself: behind it the search goes on, in the bytes that are there
// already. A frame that stays incomplete for `kSilence_us` counts as a false start, too.
//
// Messages that are not known cannot be checked: one is a frame only if it begins where a frame
// must, right behind another one or after silence; else it is skipped byte by byte. A byte costs at
// most one checksum over a frame for each plausible head that lies before it within a frame's
// length.
class Parser {
  public:
    static constexpr uint64_t kSilence_us = 200'000;

    // `known`: in the order of their ids. The table must outlive the parser.
    explicit Parser(std::span<const Known> known) : known_(known) {}

    // Takes a byte of `bytes` at a time off its front until a frame is complete, and returns it;
    // none: all bytes are taken. Call it again until then. The frame is valid until the next call.
    std::optional<Frame> next(std::span<const uint8_t>& bytes, uint64_t now_us);

    // The bytes of the frame that was returned last, for a change that keeps its length.
    std::span<uint8_t> change() { return std::span(buffer_).first(done_); }

    const ParserCounters& counters() const { return counters_; }

  private:
    enum class Look : uint8_t { kIncomplete, kFalse, kDamaged, kFrame };

    Look look() const;
    const Known* find(uint32_t id) const;
    uint32_t id() const {
        return buffer_[7] | uint32_t{buffer_[8]} << 8 | uint32_t{buffer_[9]} << 16;
    }
    std::size_t frame_bytes() const;
    std::optional<Frame> take();
    void drop(std::size_t count);
    void skip();
    void seek();

    std::span<const Known> known_;
    std::array<uint8_t, kMaxFrameBytes> buffer_{};
    std::size_t size_ = 0;
    std::size_t done_ = 0;    // bytes of the frame that was returned last
    bool is_in_step_ = true;  // the buffer begins where a frame must
    uint64_t newest_us_ = 0;
    ParserCounters counters_;
};

}  // namespace stator::mav
