// One line with MAVLink on it.
#include "link.hpp"

#include <algorithm>

#include "stator/scalar.hpp"

namespace stator::apps::mavlink {

bool Link::send(const mav::Kind& kind, std::span<const uint8_t> payload) {
    if (rehearses_) return true;
    mav::FrameBytes frame;
    if (signs_) ++signed_.time;
    // A frame that is dropped shows as lost.
    frame.put(kind, payload, sequence_++, own_, signs_ ? &signed_ : nullptr);
    return put(frame.bytes(), kind.id == mav::Heartbeat::kId ? 0 : kForHeartbeat);
}

bool Link::forward(std::span<const uint8_t> frame) {
    const auto bytes = static_cast<float>(frame.size());
    if (bytes > forward_budget_) {
        ++dropped_;
        return false;
    }
    forward_budget_ -= bytes;
    return put(frame, kForHeartbeat);
}

// `left`: bytes of room that stay free.
bool Link::put(std::span<const uint8_t> frame, std::size_t left) {
    if (!is_open() || frame.size() + left > kRoom - waiting_) {
        ++dropped_;
        return false;
    }
    for (const uint8_t byte : frame) {
        ring_[(begin_ + waiting_) % kRoom] = byte;
        ++waiting_;
    }
    return true;
}

// Bytes of the frame that waits longest.
std::size_t Link::first_frame() const {
    const std::size_t signature = at(leaving_ + 2) == mav::kIsSigned ? mav::kSignatureBytes : 0;
    return mav::kHeaderBytes + at(leaving_ + 1) + mav::kCrcBytes + signature;
}

void Link::take_radio(uint8_t free_pct) {
    float factor = 1.0F;
    if (free_pct < 25) {
        factor = 0.8F;
    } else if (free_pct < 35) {
        factor = 0.975F;
    } else if (free_pct > 50) {
        factor = 1.025F;
    }
    share_ = math::clamp(share_ * factor, kLeastShare, 1.0F);
    radio_silent_s_ = 0.0F;
}

// An activation sends what the pieces of one can carry, and what the line can. A radio that is
// silent for a while may be another one, or none.
void Link::refill(float dt) {
    radio_silent_s_ += dt;
    if (radio_silent_s_ > kRadioSilence_s) share_ = 1.0F;
    const uint32_t most_rate = settings_.most_bytes_per_s;
    const uint32_t bytes_per_s = most_rate == 0 ? bytes_per_s_ : std::min(bytes_per_s_, most_rate);
    const float rate = share_ * static_cast<float>(bytes_per_s);
    const float most = math::max(rate * kBurst_s, static_cast<float>(mav::kMaxFrameBytes));
    budget_ = math::min(budget_ + rate * dt, most);
    forward_budget_ = math::min(forward_budget_ + rate * dt * kForwarded, most);
    pieces_left_ = kPieces;
}

bool Link::next_piece(SerialBytes& piece) {
    if (adopted_) {
        const bool is_blank = *adopted_ == mav::Fingerprint{};
        piece.adopts = true;
        piece.length = is_blank ? uint8_t{0} : uint8_t{mav::kFingerprintBytes};
        std::ranges::copy(*adopted_, piece.data.begin());
        adopted_.reset();
        --pieces_left_;
        return true;
    }
    if (leaving_ == 0) {
        const std::size_t most = pieces_left_ * piece.data.size();
        while (leaving_ < waiting_) {
            const std::size_t more = first_frame();
            if (leaving_ + more > most || static_cast<float>(more) > budget_) break;
            budget_ -= static_cast<float>(more);
            leaving_ += more;
        }
        if (leaving_ == 0) return false;
    }
    const std::size_t length = std::min(leaving_, piece.data.size());
    for (std::size_t i = 0; i < length; ++i) piece.data[i] = at(i);
    piece.length = static_cast<uint8_t>(length);
    begin_ = (begin_ + length) % kRoom;
    waiting_ -= length;
    leaving_ -= length;
    piece.ends = leaving_ == 0;
    --pieces_left_;
    return true;
}

}  // namespace stator::apps::mavlink
