// What drivers of CAN controllers have in common: a queue in front of the controller, counts, and
// the node's outputs. The controller is a port, chosen at compile time:
//
//     void begin(uint64_t now_us);                     each activation begins with it
//     CanSend send(const CanFrame& frame);
//     bool take_back(CanFrame& frame);  one that was sent by `send` only, and never will be; of one
//                                       identifier the last first; false: there is none
//     bool receive(CanFrame& frame, uint64_t now_us);  false: none waits
//     void end();                                      each activation ends with it
//     CanInterfaceStatus::State state();
//     void count(CanInterfaceStatus& status);          adds what the port has counted
#pragma once

#include "can_ports.hpp"
#include "can_queue.hpp"

namespace stator::drivers::can {

enum class CanSend : uint8_t {
    kSent,    // it is the controller's now
    kFull,    // try again later
    kRefused  // it can never be sent
};

// Frames that waited for so long are given up: an old motor command is worse than none.
inline constexpr uint64_t kMaxCanWait_us = 50'000;

template <class Port>
class CanDriver {
  public:
    explicit CanDriver(Port port) : port_(port) {}

    void step(CanPorts& ports) {
        port_.begin(ports.now);
        if (ports.send) queue(*ports.send);
        take_back();
        send_waiting(ports.now);
        receive(ports);
        report(ports);
        port_.end();
    }

  private:
    static constexpr unsigned kMaxWaiting = 32;
    static constexpr unsigned kMaxReceived = 8;  // of one activation: the burst of the output

    void queue(const CanFrame& frame) {
        const bool is_frame = frame.length <= frame.data.size() &&
                              frame.id <= (frame.extended ? 0x1FFFFFFFU : 0x7FFU);
        if (!is_frame || !queue_.add(frame)) ++tx_lost_;
    }
    void take_back() {
        for (CanFrame frame; port_.take_back(frame);) {
            --frames_tx_;
            if (!queue_.put_back(frame)) ++tx_lost_;
        }
    }
    void send_waiting(uint64_t now_us) {
        if (now_us > kMaxCanWait_us) tx_lost_ += queue_.remove_older(now_us - kMaxCanWait_us);
        while (!queue_.is_empty()) {
            const CanSend result = port_.send(queue_.first());
            if (result == CanSend::kFull) return;
            ++(result == CanSend::kSent ? frames_tx_ : refused_);
            queue_.remove_first();
        }
    }
    void receive(CanPorts& ports) {
        CanFrame frame;
        for (unsigned i = 0; i < kMaxReceived && port_.receive(frame, ports.now); ++i) {
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
    CanQueue<CanFrame, kMaxWaiting> queue_;
    uint64_t frames_tx_ = 0;
    uint64_t frames_rx_ = 0;
    uint64_t refused_ = 0;
    uint64_t newest_us_ = 0;
    uint32_t tx_lost_ = 0;
    CanInterfaceStatus::State state_ = CanInterfaceStatus::State::kDown;
};

}  // namespace stator::drivers::can
