// The CAN controller of a simulated board.
#include "can_sim.hpp"

namespace stator::drivers::can::sim {

void CanSim::send(const CanFrame& frame) {
    if (device_.send == nullptr || !frame.extended || frame.length > frame.data.size()) {
        ++refused_;
        return;
    }
    device_.send({frame.timestamp_sample, frame.id, frame.length, frame.data});
    ++sent_;
}

void CanSim::step(CanPorts& ports) {
    if (ports.send) send(*ports.send);
    // A copy: time may pass between two publications, and more may come.
    const auto inbox = device_.inbox;
    const uint32_t count = device_.waiting;
    device_.waiting = 0;
    for (uint32_t i = 0; i < count; ++i) {
        const Frame& frame = inbox[i];
        ports.frames.publish([&] {
            return CanFrame{.timestamp_sample = frame.timestamp_sample,
                            .id = frame.id,
                            .extended = true,
                            .length = frame.length,
                            .data = frame.data};
        });
    }
    received_ += count;
    if (ports.fired.timers == 0) return;
    ports.status.publish([&] {
        return CanInterfaceStatus{.frames_tx = sent_,
                                  .frames_rx = received_,
                                  .tx_lost = refused_,
                                  .rx_lost = device_.lost};
    });
}

}  // namespace stator::drivers::can::sim
