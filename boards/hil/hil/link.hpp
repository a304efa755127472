// A TCP connection with MAVLink between an autopilot and a simulator.
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "mavlink/messages.hpp"
#include "stator/mavlink/parser.hpp"

namespace stator::hil {

// Of HIL_SENSOR.fields_updated: what a message has of each sensor.
inline constexpr std::uint32_t kAccel = 0x7;
inline constexpr std::uint32_t kGyro = 0x38;
inline constexpr std::uint32_t kMag = 0x1C0;
inline constexpr std::uint32_t kBaro = 0x1A00;  // pressure, height of that pressure, temperature
// Of HIL_ACTUATOR_CONTROLS.flags.
inline constexpr std::uint64_t kLockstep = 1;

// One thread, which waits for the other side. A signal that ends the flight ends each wait.
class Link {
  public:
    explicit Link(mav::Address own) : own_(own) {}
    ~Link();
    Link(const Link&) = delete;
    Link& operator=(const Link&) = delete;

    // "tcp:PORT" or "tcp:HOST:PORT". Waits until the other side listens, for a minute. Empty: done,
    // or a signal came. Else what is wrong.
    [[nodiscard]] std::string connect(const char* place);
    // "tcp:PORT", on 127.0.0.1. Waits until the other side connects.
    [[nodiscard]] std::string listen(const char* place);

    // The next frame, valid until the next call; waits for it. None: the connection is closed, a
    // signal came, or it took longer than `most`.
    std::optional<mav::Frame> next(
        std::chrono::milliseconds most = std::chrono::milliseconds::max());
    bool is_open() const { return descriptor_ >= 0; }

    // What a closed connection is sent is lost.
    template <class Message>
    void send(const Message& message) {
        frame_.put(message, sequence_++, own_);
        write(frame_.bytes());
    }

  private:
    void write(std::span<const std::uint8_t> bytes);
    void close();

    mav::Address own_;
    int descriptor_ = -1;
    mav::Parser parser_{mav::kKnown};
    std::array<std::uint8_t, 4096> buffer_{};
    std::span<const std::uint8_t> unread_;
    mav::FrameBytes frame_;
    std::uint8_t sequence_ = 0;
};

}  // namespace stator::hil
