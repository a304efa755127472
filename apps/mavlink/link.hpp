// One line with MAVLink on it: what comes in, what waits to go out, and what it may carry.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>

#include "mavlink/messages.hpp"
#include "messages/serial_bytes.hpp"
#include "messages/serial_status.hpp"
#include "stator/mavlink/frame.hpp"
#include "stator/mavlink/parser.hpp"
#include "stator/mavlink/signature.hpp"

namespace stator::apps::mavlink {

// What is at the other end; `role1` of mavlink.yaml.
enum class Role : uint8_t { kGround, kOnBoard, kRadio };

// What systems on a line may do; bits of `allows1` of mavlink.yaml.
enum class Right : uint8_t {
    kFly,
    kSteer,
    kPlan,
    kTune,
    kService,
    kKill,
    kConsole,
    kForward,
    kSign,
    kOpen
};

// What a line is by the graph.
struct LinkSettings {
    Role role = Role::kGround;
    uint32_t rights = 0;
    uint32_t most_bytes_per_s = 0;  // 0: what the line carries
};

// Frames that wait are sent whole, in their order, at the line's rate. A frame that finds no room
// is dropped and counted; so what can wait asks for room first: streams once the line keeps up, and
// long answers (parameters, items, files) once little waits.
class Link {
  public:
    static constexpr unsigned kPieces = 8;  // of one activation: the burst of the output

    Link() : parser_(mav::kKnown) {}

    // What the line says of itself; before that nothing is sent.
    void take_status(const SerialStatus& status) {
        bytes_per_s_ = status.bytes_per_s;
        signs_ = status.signs;
    }
    // Whether frames have signatures; then those of ours have this link and time, or a later one.
    bool signs() const { return signs_; }
    void set_time(uint8_t link, uint64_t time) {
        signed_.link = link;
        signed_.time = std::max(signed_.time, time);
    }
    // The key with this fingerprint counts from now on; a blank one: none does.
    void adopt(const mav::Fingerprint& fingerprint) { adopted_ = fingerprint; }
    bool is_open() const { return bytes_per_s_ != 0; }
    void set_own(mav::Address own) { own_ = own; }
    mav::Address own() const { return own_; }
    void set(const LinkSettings& settings) { settings_ = settings; }
    Role role() const { return settings_.role; }
    bool allows(Right right) const {
        return (settings_.rights >> static_cast<unsigned>(right) & 1U) != 0;
    }
    // What a radio says of its buffer: how much of it is free, in percent.
    void take_radio(uint8_t free_pct);

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
    static constexpr std::size_t kForHeartbeat = 36;  // whatever else waits
    static constexpr std::size_t kBulkWaits = 300;
    static constexpr float kBurst_s = 0.1F;    // of bytes that an idle line may catch up on
    static constexpr float kForwarded = 0.5F;  // of the line, for frames of others
    // Of a radio whose buffer fills: PX4's figures.
    static constexpr float kLeastShare = 0.05F;
    static constexpr float kRadioSilence_s = 5.0F;

    bool send(const mav::Kind& kind, std::span<const uint8_t> payload);
    bool put(std::span<const uint8_t> frame, std::size_t left);
    std::size_t first_frame() const;
    uint8_t at(std::size_t index) const { return ring_[(begin_ + index) % kRoom]; }

    mav::Parser parser_;
    mav::Address own_;
    bool rehearses_ = false;
    bool signs_ = false;
    mav::Signed signed_;
    std::optional<mav::Fingerprint> adopted_;  // to be sent before all else
    uint8_t sequence_ = 0;
    LinkSettings settings_;
    uint32_t bytes_per_s_ = 0;
    float share_ = 1.0F;  // that a radio has room for
    float radio_silent_s_ = 0.0F;
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
