// A simulated CAN bus.
#include "can_bus.hpp"

#include <algorithm>

namespace stator::board {

namespace {

// Davis, Burns, Bril, Lukkien, "Controller Area Network (CAN) schedulability analysis", Real-Time
// Systems 35, 2007: at most 80 + 10 n bits for n bytes and an identifier of 29 bits. 1 us a bit.
std::uint64_t duration_us(const dronecan::Frame& frame) {
    return 80 + 10 * std::uint64_t{frame.length};
}

}  // namespace

void CanBus::send(const dronecan::Frame& frame, Sender sender, std::uint64_t now_us) {
    if (count_ == kMaxWaiting) {
        ++lost_;
        return;
    }
    waiting_[count_++] = {frame, sender, 0};
    if (!sending_) begin(now_us);
}

void CanBus::begin(std::uint64_t now_us) {
    if (count_ == 0) return;
    Sent* const end = waiting_.data() + count_;
    // The first of equal ones: frames of one transfer keep their order.
    Sent* const first = std::min_element(
        waiting_.data(), end, [](const Sent& a, const Sent& b) { return a.frame.id < b.frame.id; });
    sending_ = *first;
    sending_->end_us = now_us + duration_us(first->frame);
    std::move(first + 1, end, first);
    --count_;
}

CanBus::Sent CanBus::finish() {
    const Sent sent = *sending_;
    sending_.reset();
    begin(sent.end_us);
    return sent;
}

}  // namespace stator::board
