// Finds the frames in a stream of bytes.
#include "stator/mavlink/parser.hpp"

#include <algorithm>

namespace stator::mav {

const Known* Parser::find(uint32_t id) const {
    const auto found = std::ranges::lower_bound(known_, id, {}, &Known::id);
    return found != known_.end() && found->id == id ? &*found : nullptr;
}

// Of the frame that the buffer begins with, by its head.
std::size_t Parser::frame_bytes() const {
    return kHeaderBytes + buffer_[1] + kCrcBytes + (buffer_[2] == kIsSigned ? kSignatureBytes : 0);
}

// At what begins with the first byte of the buffer. What can be known from a part of the head is.
Parser::Look Parser::look() const {
    if (size_ > 2 && buffer_[2] > kIsSigned) return Look::kFalse;
    if (size_ < kHeaderBytes) return Look::kIncomplete;
    const Known* const known = find(id());
    if (known == nullptr && (!is_in_step_ || buffer_[5] == 0)) return Look::kFalse;
    if (size_ < frame_bytes()) return Look::kIncomplete;
    const std::size_t end = kHeaderBytes + buffer_[1];
    if (known == nullptr) {  // zeros at the end of a payload do not travel
        return buffer_[1] > 1 && buffer_[end - 1] == 0 ? Look::kFalse : Look::kFrame;
    }
    const uint16_t crc =
        crc16(crc16(kCrcSeed, std::span(buffer_).first(end).subspan(1)), known->crc_extra);
    const auto sent = static_cast<uint16_t>(buffer_[end] | buffer_[end + 1] << 8);
    return crc == sent ? Look::kFrame : Look::kDamaged;
}

void Parser::drop(std::size_t count) {
    std::copy(buffer_.begin() + static_cast<std::ptrdiff_t>(count),
              buffer_.begin() + static_cast<std::ptrdiff_t>(size_), buffer_.begin());
    size_ -= count;
}

// The first byte of the buffer, a false start.
void Parser::skip() {
    is_in_step_ = false;
    ++counters_.skipped;
    drop(1);
}

// To the next start byte that there is.
void Parser::seek() {
    const auto end = buffer_.begin() + static_cast<std::ptrdiff_t>(size_);
    const auto start = std::find(buffer_.begin(), end, kStart);
    const auto skipped = static_cast<std::size_t>(start - buffer_.begin());
    if (skipped == 0) return;
    is_in_step_ = false;
    counters_.skipped += static_cast<uint32_t>(skipped);
    drop(skipped);
}

// The first frame in the buffer, behind false starts.
std::optional<Frame> Parser::take() {
    drop(done_);
    done_ = 0;
    for (seek(); size_ != 0; seek()) {
        const Look found = look();
        if (found == Look::kIncomplete) return {};
        if (found == Look::kFrame) {
            ++counters_.frames;
            is_in_step_ = true;
            done_ = frame_bytes();
            const std::span<const uint8_t> bytes = std::span(buffer_).first(done_);
            return Frame{.id = id(),
                         .source = {.system = buffer_[5], .component = buffer_[6]},
                         .sequence = buffer_[4],
                         .is_signed = buffer_[2] == kIsSigned,
                         .known = find(id()),
                         .bytes = bytes,
                         .payload = bytes.subspan(kHeaderBytes, buffer_[1])};
        }
        if (found == Look::kDamaged) ++counters_.damaged;
        skip();
    }
    return {};
}

std::optional<Frame> Parser::next(std::span<const uint8_t>& bytes, uint64_t now_us) {
    auto frame = take();
    // Silence ends a frame that is not complete; there may be whole ones behind its start.
    while (!frame && size_ != 0 && now_us >= newest_us_ + kSilence_us) {
        skip();
        frame = take();
    }
    while (!frame && !bytes.empty()) {
        const uint8_t byte = bytes.front();
        bytes = bytes.subspan(1);
        if (now_us >= newest_us_ + kSilence_us) is_in_step_ = true;
        newest_us_ = now_us;
        if (size_ == done_ && byte != kStart) {
            is_in_step_ = false;
            ++counters_.skipped;
            continue;
        }
        buffer_[size_++] = byte;
        frame = take();
    }
    return frame;
}

}  // namespace stator::mav
