// Puts transfers together from frames that anybody on the bus may have sent.
//
// Nothing on the bus is trusted. A frame counts only from a node of the allow-list, of a wanted
// type, and within its rate; whatever is wrong with it or with its transfer ends as a counter. The
// work for a frame is bounded, and all storage is here.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>

#include "stator/dronecan/frame.hpp"

namespace stator::dronecan {

// A set of node ids. 0 stands for nodes that have none yet.
class NodeSet {
  public:
    constexpr void add(unsigned node) {
        if (node <= kMaxNodeId) words_[node / 64] |= uint64_t{1} << (node % 64);
    }
    constexpr void add_range(int first, int last) {
        for (int node = first < 0 ? 0 : first; node <= last && node <= kMaxNodeId; ++node) {
            add(static_cast<unsigned>(node));
        }
    }
    constexpr bool has(unsigned node) const {
        return node <= kMaxNodeId && ((words_[node / 64] >> (node % 64)) & 1) != 0;
    }
    constexpr unsigned size() const {
        return static_cast<unsigned>(std::popcount(words_[0]) + std::popcount(words_[1]));
    }

  private:
    std::array<uint64_t, 2> words_{};
};

// A type that a node wants to receive.
struct Wanted {
    DataType type;
    uint16_t frames_per_second;  // of one sender, at most; what is beyond is dropped and counted
    // Of nodes without id, too. Their frames have two bits of the type only, so that of types with
    // the same two, one can be wanted.
    bool anonymous = false;
};

template <class Message>
constexpr Wanted want(uint16_t frames_per_second) {
    return {Message::kType, frames_per_second};
}
template <class Message>
constexpr Wanted want_anonymous(uint16_t frames_per_second) {
    return {Message::kType, frames_per_second, true};
}

struct ReceiverCounters {
    uint32_t transfers = 0;    // complete and sound
    uint32_t refused = 0;      // frames of nodes that are not allowed
    uint32_t over_rate = 0;    // frames beyond the rate
    uint32_t malformed = 0;    // frames of impossible length or out of place
    uint32_t repeated = 0;     // frames and transfers that came again
    uint32_t broken_off = 0;   // transfers whose end never came
    uint32_t wrong_crc = 0;    // transfers
    uint32_t no_room = 0;      // transfers for which no session was free
    uint32_t undecodable = 0;  // transfers whose payload is none of the type; counted by the user
    uint32_t rejected() const {
        return refused + over_rate + malformed + broken_off + wrong_crc + no_room + undecodable;
    }
};

// One sender's transfers of one type.
struct Session {
    uint64_t started_us = 0;  // of the newest transfer
    uint64_t window_us = 0;   // start of the second that is being counted
    uint16_t frames = 0;      // in that second
    uint16_t length = 0;      // bytes so far
    uint16_t crc = 0;         // as the transfer says
    uint8_t type = 0;         // index among the wanted ones
    uint8_t source = 0;
    uint8_t transfer_id = 0;
    bool used = false;
    bool complete = false;  // a transfer with `transfer_id` came whole
    bool open = false;      // frames of one are still to come
    bool several = false;   // it has more than one frame
    bool toggle = false;    // of the next frame
};

class ReceiverCore {
  public:
    // What other implementations take for it, too: after this long, a transfer id may come again.
    static constexpr uint64_t kTransferTimeout_us = 2'000'000;

    const ReceiverCounters& counters() const { return counters_; }
    void count_undecodable() { ++counters_.undecodable; }
    void allow(const NodeSet& nodes) { allowed_ = nodes; }
    // The node that requests and responses must be for.
    void set_own_id(uint8_t node_id) { own_id_ = node_id; }

    // The newest transfer, after `accept` said true and until it is called again.
    const Header& header() const { return header_; }
    uint8_t transfer_id() const { return transfer_id_; }
    std::span<const uint8_t> payload() const { return payload_; }
    uint64_t begun_us() const { return begun_us_; }  // when its first frame came
    template <class Message>
    bool is() const {
        return header_.kind == Message::kType.kind && header_.type_id == Message::kType.id;
    }

  protected:
    struct Storage {
        std::span<const Wanted> wanted;
        std::span<Session> sessions;
        std::span<uint8_t> bytes;  // of all sessions
    };
    bool accept(const Storage& storage, const Frame& frame, uint64_t now_us);

  private:
    Session* session_for(const Storage& storage, const Header& header, unsigned type, bool starts,
                         uint64_t now_us);
    bool within_rate(Session& session, uint16_t most, uint64_t now_us);
    bool start(Session& session, uint8_t tail, uint64_t now_us);
    bool continues(Session& session, uint8_t tail, uint64_t now_us);
    bool take(Session& session, const Frame& frame, std::span<uint8_t> room);
    bool finish(Session& session, const Wanted& wanted, std::span<const uint8_t> room);

    ReceiverCounters counters_;
    NodeSet allowed_;
    Header header_;
    std::span<const uint8_t> payload_;
    uint64_t begun_us_ = 0;
    uint8_t own_id_ = 0;
    uint8_t transfer_id_ = 0;
};

// `kSessions` pairs of sender and type at a time, `kMaxBytes` of payload each.
template <unsigned kSessions, unsigned kMaxBytes>
class Receiver : public ReceiverCore {
  public:
    explicit Receiver(std::span<const Wanted> wanted) : wanted_(wanted) {}

    // Takes one frame; true if it ended a transfer, which then stands in `header`, `transfer_id`
    // and `payload`. `now_us` never goes back.
    bool accept(const Frame& frame, uint64_t now_us) {
        return ReceiverCore::accept({wanted_, sessions_, bytes_}, frame, now_us);
    }

  private:
    std::span<const Wanted> wanted_;
    std::array<Session, kSessions> sessions_{};
    std::array<uint8_t, std::size_t{kSessions} * kMaxBytes> bytes_{};
};

}  // namespace stator::dronecan
