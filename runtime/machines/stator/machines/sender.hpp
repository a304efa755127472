// The sending side of a link's end: of each topic the newest sample waits, the most urgent topic
// goes first, and one frame is on the wire at a time.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

#include "stator/frame.hpp"
#include "stator/machines/end.hpp"
#include "stator/machines/protocol.hpp"

namespace stator::machines {

// `kMaxBytes`: of a message.
template <unsigned kTopics, size_t kMaxBytes>
class Sender {
  public:
    Sender(End& end, const Identity& identity) : end_(&end), identity_(identity) {}

    // A sample of a topic, most urgent first from 0: takes the place of one that waits.
    void offer(unsigned topic, std::span<const std::byte> sample) {
        Waiting& waiting = waiting_[topic];
        if (waiting.bytes != 0) ++replaced_;
        std::memcpy(waiting.sample.data(), sample.data(), sample.size());
        waiting.bytes = static_cast<uint16_t>(sample.size());
    }
    // Each period of the link.
    void tick() {
        const bool is_slow = end_->is_up() && end_->peer_boot() == greeted_;
        if (is_slow && ++ticks_ < kSlowHello) return;
        ticks_ = 0;
        greeted_ = end_->is_up() ? end_->peer_boot() : 0;
        wants_hello_ = true;
    }
    // Starts the next frame, if there is one and the wire is free.
    void go_on() {
        if (!end_->is_idle()) return;
        size_t count = 0;
        if (wants_hello_) {
            wants_hello_ = false;
            const Hello hello{identity_, end_->boot(), end_->agrees() ? end_->peer_boot() : 0};
            write_hello(body_.data(), hello_number_++, hello);
            count = kHelloBytes;
        } else if (end_->is_up()) {
            count = next_sample();
        } else {
            forget();
        }
        if (count == 0) return;
        end_->start({frame_.data(), write_frame(body_.data(), count, frame_.data())});
        end_->note_sent(sent_, replaced_);
    }

  private:
    struct Waiting {
        std::array<uint8_t, kMaxBytes> sample;
        uint16_t bytes = 0;  // 0: none waits
        uint16_t number = 0;
    };
    static constexpr size_t kMaxBody = std::max(kHelloBytes, kHeadBytes + kMaxBytes);

    size_t next_sample() {
        for (unsigned topic = 0; topic < kTopics; ++topic) {
            Waiting& waiting = waiting_[topic];
            if (waiting.bytes == 0) continue;
            write_head(body_.data(), static_cast<uint8_t>(topic), waiting.number++);
            std::memcpy(body_.data() + kHeadBytes, waiting.sample.data(), waiting.bytes);
            const size_t count = kHeadBytes + waiting.bytes;
            waiting.bytes = 0;
            ++sent_;
            return count;
        }
        return 0;
    }
    // Nobody takes what waits; it is old once the peer is back.
    void forget() {
        for (Waiting& waiting : waiting_) waiting.bytes = 0;
    }

    End* end_;
    Identity identity_;
    std::array<Waiting, kTopics> waiting_{};
    std::array<uint8_t, kMaxBody + kCrcBytes> body_{};
    std::array<uint8_t, frame_bytes(kMaxBody)> frame_{};  // on the wire
    uint32_t sent_ = 0;
    uint32_t replaced_ = 0;
    uint32_t ticks_ = 0;
    uint32_t greeted_ = 0;  // the peer that has had a hello since it is up
    uint16_t hello_number_ = 0;
    bool wants_hello_ = true;
};

}  // namespace stator::machines
