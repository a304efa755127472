// The receiving side of a link's end: finds frames, knows the peer, and passes on only samples that
// are sound, new, and young enough.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>

#include "stator/frame.hpp"
#include "stator/machines/end.hpp"
#include "stator/machines/protocol.hpp"

namespace stator::machines {

struct ReceivedTopic {
    uint16_t bytes;       // of a sample
    uint32_t max_age_us;  // of its readers, the longest
};

struct ReceivedCounts {
    uint32_t received = 0;
    uint32_t lost = 0;
    uint32_t damaged = 0;
    uint32_t repeated = 0;
    uint32_t too_old = 0;
    uint32_t refused = 0;
    uint32_t oldest_us = 0;
    bool operator==(const ReceivedCounts&) const = default;
};

template <unsigned kTopics, size_t kMaxBytes>
class Receiver {
  public:
    Receiver(End& end, const Identity& identity, const ReceivedTopic* topics)
        : end_(&end), identity_(identity), topics_(topics) {}

    static constexpr unsigned kNone = kTopics;

    // Of each activation.
    void begin(uint64_t now_us) {
        now_us_ = now_us;
        left_ = kBudget;
        if (now_us_ > heard_us_ + kSilence_us) end_->note_peer(0, 0, false);
    }
    // The topic of the next good sample; `kNone`: there is no other in this activation.
    unsigned next() {
        uint8_t byte = 0;
        while (left_ != 0 && end_->take(byte)) {
            --left_;
            const bool is_whole = reader_.take(byte);
            if (byte != 0) {
                has_bytes_ = true;
                continue;
            }
            if (!is_whole) {
                counts_.damaged += has_bytes_ ? 1U : 0U;
            } else {
                const unsigned topic = take_frame();
                has_bytes_ = false;
                if (topic != kNone) return topic;
            }
            has_bytes_ = false;
        }
        return kNone;
    }
    // The sample that `next` has found: its bytes, without the padding at its end.
    const uint8_t* sample() const { return reader_.body() + kHeadBytes; }
    // When it was published: never later than now, whatever the peer's clock says.
    uint64_t timestamp_us() const { return timestamp_us_; }

    const ReceivedCounts& counts() const { return counts_; }
    bool disagrees() const { return end_->peer_boot() != 0 && !end_->agrees(); }

  private:
    // Of an activation: what a line at full speed brings in the longest time between two.
    static constexpr uint32_t kBudget = 2048;
    // The other clock may be ahead of this one by so much.
    static constexpr uint64_t kAhead_us = 10'000;
    static constexpr size_t kMaxBody = std::max(kHelloBytes, kHeadBytes + kMaxBytes);

    struct State {
        uint64_t timestamp_us = 0;
        uint16_t number = 0;
        bool is_known = false;
    };

    unsigned take_frame() {
        const uint8_t* const body = reader_.body();
        const size_t count = reader_.count();
        if (count >= kHeadBytes && body[0] == kHello) {
            take_hello(body, count);
            return kNone;
        }
        const unsigned topic = count > kHeadBytes ? body[0] : kTopics;
        if (!end_->agrees() || topic >= kTopics || count != kHeadBytes + topics_[topic].bytes) {
            ++counts_.refused;
            return kNone;
        }
        heard_us_ = now_us_;
        return is_next(states_[topic], number_in(body)) && is_young(topic) ? topic : kNone;
    }
    void take_hello(const uint8_t* body, size_t count) {
        Hello hello;
        if (!read_hello(body, count, hello)) {
            ++counts_.refused;
            return;
        }
        heard_us_ = now_us_;
        if (hello.boot != end_->peer_boot()) states_ = {};  // its numbers begin again
        end_->note_peer(hello.boot, hello.heard, hello.identity == identity_);
    }
    bool is_next(State& state, uint16_t number) {
        const auto step = static_cast<uint16_t>(number - state.number);
        if (state.is_known && (step == 0 || step > INT16_MAX)) {
            ++counts_.repeated;
            return false;
        }
        if (state.is_known) counts_.lost += step - 1U;
        state.number = number;
        state.is_known = true;
        return true;
    }
    bool is_young(unsigned topic) {
        State& state = states_[topic];
        std::memcpy(&timestamp_us_, sample(), sizeof timestamp_us_);
        const bool is_ahead = timestamp_us_ > now_us_;
        const uint64_t age_us = is_ahead ? 0 : now_us_ - timestamp_us_;
        const bool is_wrong = is_ahead && timestamp_us_ - now_us_ > kAhead_us;
        if (is_wrong || age_us > topics_[topic].max_age_us || timestamp_us_ < state.timestamp_us) {
            ++counts_.too_old;
            return false;
        }
        timestamp_us_ = std::min(timestamp_us_, now_us_);
        state.timestamp_us = timestamp_us_;
        counts_.oldest_us = std::max(counts_.oldest_us, static_cast<uint32_t>(age_us));
        ++counts_.received;
        return true;
    }

    End* end_;
    Identity identity_;
    const ReceivedTopic* topics_;
    FrameReader<kMaxBody> reader_;
    std::array<State, kTopics + 1> states_{};  // one more: a direction may have no topics
    ReceivedCounts counts_;
    uint64_t now_us_ = 0;
    uint64_t heard_us_ = 0;
    uint64_t timestamp_us_ = 0;
    uint32_t left_ = 0;
    bool has_bytes_ = false;
};

}  // namespace stator::machines
