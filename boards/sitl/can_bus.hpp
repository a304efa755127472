// A simulated CAN bus at 1 Mbit/s: one frame at a time, the lowest identifier of those that wait
// first.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "stator/dronecan/frame.hpp"

namespace stator::board {

class CanBus {
  public:
    // Which controllers there are; each hears all frames but its own.
    enum class Sender : std::uint8_t { kVehicle, kParts };
    struct Sent {
        dronecan::Frame frame;
        Sender sender;
        std::uint64_t end_us;
    };
    static constexpr std::uint64_t kNever = UINT64_MAX;

    // Begins at `now_us` if the bus is free. A frame that finds no room is lost, and counted.
    void send(const dronecan::Frame& frame, Sender sender, std::uint64_t now_us);
    // When the frame that is being sent ends.
    std::uint64_t next_event_us() const { return sending_ ? sending_->end_us : kNever; }
    // Takes that frame, and begins the next.
    Sent finish();
    std::uint32_t lost() const { return lost_; }

  private:
    static constexpr unsigned kMaxWaiting = 128;

    void begin(std::uint64_t now_us);

    std::array<Sent, kMaxWaiting> waiting_{};  // in the order they came
    unsigned count_ = 0;
    std::optional<Sent> sending_;
    std::uint32_t lost_ = 0;
};

}  // namespace stator::board
