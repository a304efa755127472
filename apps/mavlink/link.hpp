// One line with MAVLink on it: what comes in, what waits to go out, and what it may carry.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "mavlink/messages.hpp"
#include "messages/serial_bytes.hpp"
#include "messages/serial_status.hpp"
#include "stator/mavlink/frame.hpp"
#include "stator/mavlink/parser.hpp"

namespace stator::apps::mavlink {

// What is at the other end.
enum class Role : uint8_t { kGround, kOnBoard, kRadio };

// Frames that wait are sent whole, in their order, at the line's rate. A frame that finds no room
// is dropped and counted; so what can wait asks for room first: streams once the line keeps up, and
// long answers (parameters, items, files) once little waits.
class Link {
  public:
    static constexpr unsigned kPieces = 8;  // of one activation: the burst of the output

    Link() : parser_(mav::kKnown) {}

    // What the line says of itself; before that nothing is sent.
    void take_status(const SerialStatus& status) { bytes_per_s_ = status.bytes_per_s; }
    bool is_open() const { return bytes_per_s_ != 0; }
    void set_own(mav::Address own) { own_ = own; }
    mav::Address own() const { return own_; }

    // The next frame in the bytes, as of the parser.
    std::optional<mav::Frame> next(std::span<const uint8_t>& bytes, uint64_t now_us) {
        return parser_.next(bytes, now_us);
    }
    const mav::ParserCounters& counters() const { return parser_.counters(); }

    // False if there was no room.
    template <class Message>
    bool send(const Message& message) {
        return mav::with_payload(message, [this](std::span<const uint8_t> payload) {
            return send(mav::kKindOf<Message>, payload);
        });
    }
    // A frame of another line, as it is. Such frames get half of the line at most. False: dropped.
    bool forward(std::span<const uint8_t> frame);
    // Whether the line keeps up: what waits goes out at once.
    bool has_room_for_streams() const { return static_cast<float>(waiting_) <= budget_; }
    bool has_room_for_bulk() const { return waiting_ <= kBulkWaits && has_room_for_streams(); }
    uint32_t dropped() const { return dropped_; }
    // While it rehearses, what is sent does not go out and counts as sent.
    void rehearse(bool is_on) { rehearses_ = is_on; }

    // Once in each activation: gives the line its bytes of `dt` seconds.
    void refill(float dt);
    // The next piece to go out in this activation; false: none.
    bool next_piece(SerialBytes& piece);

  private:
    static constexpr std::size_t kRoom = 1024;
    static constexpr std::size_t kForHeartbeat = 32;  // whatever else waits
    static constexpr std::size_t kBulkWaits = 300;
    static constexpr float kBurst_s = 0.1F;    // of bytes that an idle line may catch up on
    static constexpr float kForwarded = 0.5F;  // of the line, for frames of others

    bool send(const mav::Kind& kind, std::span<const uint8_t> payload);
    bool put(std::span<const uint8_t> frame, std::size_t left);
    std::size_t first_frame() const;
    uint8_t at(std::size_t index) const { return ring_[(begin_ + index) % kRoom]; }

    mav::Parser parser_;
    mav::Address own_;
    bool rehearses_ = false;
    uint8_t sequence_ = 0;
    uint32_t bytes_per_s_ = 0;
    float budget_ = 0.0F;          // bytes
    float forward_budget_ = 0.0F;  // of frames of other lines
    std::array<uint8_t, kRoom> ring_{};
    std::size_t begin_ = 0;
    std::size_t waiting_ = 0;
    std::size_t leaving_ = 0;  // in this activation, whole frames
    unsigned pieces_left_ = 0;
    uint32_t dropped_ = 0;
};

}  // namespace stator::apps::mavlink
