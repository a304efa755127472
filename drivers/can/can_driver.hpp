// What drivers of CAN controllers have in common: a queue in front of the controller, counts, and
// the node's outputs. The controller is a port, chosen at compile time:
//
//     void begin(uint64_t now_us);                     each activation begins with it
//     CanSend send(const CanFrame& frame);
//     bool receive(CanFrame& frame, uint64_t now_us);  false: none waits
//     CanInterfaceStatus::State state();
//     void count(CanInterfaceStatus& status);          adds what the port has counted
#pragma once

#include "can_ports.hpp"
#include "can_queue.hpp"

namespace stator {

enum class CanSend : uint8_t {
    kSent,    // it is the controller's now
    kFull,    // try again later
    kRefused  // it can never be sent
};

template <class Port>
class CanDriver {
  public:
    // Frames that waited for so long are given up: an old motor command is worse than none.
    static constexpr uint64_t kMostWait_us = 50'000;

    explicit CanDriver(Port port) : port_(port) {}

    void step(CanPorts& ports) {
        port_.begin(ports.now);
        if (ports.send) queue(*ports.send, ports.now);
        send_waiting(ports.now);
        receive(ports);
        report(ports);
    }
    Port& port() { return port_; }

  private:
    static constexpr unsigned kMostWaiting = 32;
    static constexpr unsigned kMostReceived = 8;  // of one activation: the burst of the output
    struct Item {
        CanFrame frame;
        uint64_t queued_us;
    };

    void queue(const CanFrame& frame, uint64_t now_us) {
        const bool is_frame = frame.length <= frame.data.size() &&
                              frame.id <= (frame.extended ? 0x1FFFFFFFU : 0x7FFU);
        if (!is_frame || !queue_.add({frame, now_us})) ++tx_lost_;
    }
    void send_waiting(uint64_t now_us) {
        if (now_us > kMostWait_us) tx_lost_ += queue_.remove_older(now_us - kMostWait_us);
        while (!queue_.is_empty()) {
            const CanSend result = port_.send(queue_.first().frame);
            if (result == CanSend::kFull) return;
            ++(result == CanSend::kSent ? frames_tx_ : refused_);
            queue_.remove_first();
        }
    }
    void receive(CanPorts& ports) {
        CanFrame frame;
        for (unsigned i = 0; i < kMostReceived && port_.receive(frame, ports.now); ++i) {
            // Samples of a topic keep their order in time, whatever the controller's clock did.
            if (frame.timestamp_sample < newest_us_) frame.timestamp_sample = newest_us_;
            newest_us_ = frame.timestamp_sample;
            ++frames_rx_;
            ports.frames.publish([&] { return frame; });
        }
    }
    void report(CanPorts& ports) {
        const auto state = port_.state();
        if (state == state_ && ports.fired.timers == 0) return;
        state_ = state;
        CanInterfaceStatus status{.frames_tx = frames_tx_,
                                  .frames_rx = frames_rx_,
                                  .tx_lost = tx_lost_ + static_cast<uint32_t>(refused_),
                                  .state = state};
        port_.count(status);
        ports.status.publish([&] { return status; });
    }

    Port port_;
    CanQueue<Item, kMostWaiting> queue_;
    uint64_t frames_tx_ = 0;
    uint64_t frames_rx_ = 0;
    uint64_t refused_ = 0;
    uint64_t newest_us_ = 0;
    uint32_t tx_lost_ = 0;
    CanInterfaceStatus::State state_ = CanInterfaceStatus::State::kDown;
};

}  // namespace stator
