// The CAN controller of a simulated board.
#pragma once

#include <array>
#include <cstdint>

#include "can_ports.hpp"

namespace stator::drivers::can::sim {

class CanSim {
  public:
    struct Frame {
        uint64_t timestamp_sample = 0;  // us
        uint32_t id = 0;
        uint8_t length = 0;
        std::array<uint8_t, 8> data{};
    };
    // The board fills the inbox and raises received; a frame too many is lost. Extended frames
    // only.
    struct Device {
        static constexpr unsigned kInbox = 8;
        std::array<Frame, kInbox> inbox{};
        uint32_t waiting = 0;
        uint32_t lost = 0;
        // The board puts its function here; without one, nothing can be sent.
        void (*send)(const Frame& frame) = nullptr;

        void receive(const Frame& frame) {
            if (waiting < kInbox) {
                inbox[waiting++] = frame;
            } else {
                ++lost;
            }
        }
    };

    explicit CanSim(Device& device) : device_(device) {}
    void step(CanPorts& ports);

  private:
    void send(const CanFrame& frame);

    Device& device_;
    uint64_t received_ = 0;
    uint64_t sent_ = 0;
    uint32_t refused_ = 0;
};

}  // namespace stator::drivers::can::sim
