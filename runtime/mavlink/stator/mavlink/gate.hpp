// Between a line and what reads and writes it: all that needs the key of signatures.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>

#include "stator/mavlink/parser.hpp"
#include "stator/mavlink/shared_key.hpp"

namespace stator::mav {

// A driver has one for each line, so that no topic, and so no recording, has a key:
//
// - Only whole frames go in. One with a wrong signature does not, while there is a key; which
//   unsigned ones count, and whether a time is too old, others decide.
// - In SETUP_SIGNING the fingerprint of the key takes the key's place. The key waits here until
//   `adopt` names its fingerprint.
// - Frames that go out with the flag of signed ones and room for a signature get their hash. That
//   of a frame which is signed already stays the same.
//
// For a while after the start, and after the key has changed, the line waits: what was read before
// is gone by then.
class Gate {
  public:
    explicit Gate(SharedKey& shared, std::span<const Known> known)
        : shared_(shared), parser_(known) {}

    // First in each activation: takes over a new key.
    void follow(uint64_t now_us);
    // Whether it is known which key there is.
    bool is_open() const { return shared_.is_known(); }
    // Whether frames must be signed.
    bool signs() const { return key_.state != SigningKey::State::kNone; }

    // Fills `into` as far as it can, and returns how much that is. `take` gives the next byte of
    // the line; false: none.
    template <class Take>
    std::size_t pass(std::span<uint8_t> into, uint64_t now_us, Take take) {
        if (!is_open() || now_us < settled_us_) return 0;
        std::size_t count = 0;
        while (count < into.size() && (!passing_.empty() || find(now_us, take))) {
            const std::size_t part = std::min(into.size() - count, passing_.size());
            std::copy_n(passing_.begin(), part, into.begin() + static_cast<std::ptrdiff_t>(count));
            passing_ = passing_.subspan(part);
            count += part;
        }
        return count;
    }
    // Of whole frames in a row, a piece that goes out. `ends`: the next one begins with a frame.
    void sign(std::span<uint8_t> piece, bool ends);
    // The key with this fingerprint counts from now on, on all lines; an empty one: none does.
    // While another line does the same, it is as if this had not been called.
    void adopt(std::span<const uint8_t> fingerprint);

  private:
    static constexpr uint64_t kSettles_us = 100'000;

    // Whether there is another frame that passes.
    template <class Take>
    bool find(uint64_t now_us, Take take) {
        uint8_t byte = 0;
        std::span<const uint8_t> bytes;
        while (true) {
            if (const auto frame = parser_.next(bytes, now_us)) {
                if (!passes(*frame)) continue;
                passing_ = frame->bytes;
                return true;
            }
            if (!take(byte)) return false;
            bytes = {&byte, 1};
        }
    }
    bool passes(const Frame& frame);
    bool is_good(const Frame& frame) const;
    void keep_key_back(const Frame& frame);
    void take_head(std::size_t at, uint8_t byte);

    SharedKey& shared_;
    uint32_t version_ = 0;
    SigningKey key_;
    uint64_t settled_us_ = kSettles_us;
    SigningKeyBytes offered_{};  // the newest of SETUP_SIGNING
    Parser parser_;
    std::span<const uint8_t> passing_;  // in the parser
    // Of the frame that goes out.
    std::size_t at_ = 0;
    std::size_t end_ = 0;
    bool is_signed_ = false;
    Sha256 sha_;
    std::array<uint8_t, kHashBytes> hash_{};
};

}  // namespace stator::mav
