// A serial line of a chip as a device of a graph.
#include "serial_usart.hpp"

#include <algorithm>
#include <span>

#include "mavlink/messages.hpp"

namespace stator::drivers::serial::usart {

void SerialUsart::start() {
    port_.start({device_.base}, device_.clock_hz, device_.baud);
    status_.bytes_per_s = device_.baud / kBitsOfByte;
    device_.port = &port_;
    if (device_.key != nullptr) gate_.emplace(*device_.key, mav::kKnown);
}

void SerialUsart::take(const SerialBytes& piece) {
    const std::size_t length = std::min<std::size_t>(piece.length, piece.data.size());
    if (piece.adopts) {
        if (gate_) gate_->adopt(std::span(piece.data).first(length));
        return;
    }
    auto data = piece.data;
    const auto bytes = std::span(data).first(length);
    if (gate_) gate_->sign(bytes, piece.ends);
    datagram_ += static_cast<uint32_t>(length);
    if (!is_broken_) is_broken_ = !port_.add(bytes);
    if (!piece.ends) return;
    if (is_broken_) {
        port_.drop();
        status_.tx_lost += datagram_;
    } else {
        port_.commit();
        status_.sent += datagram_;
    }
    is_broken_ = false;
    datagram_ = 0;
}

// Of a lost piece it is not known whether it was an end: what came before and what comes next may
// be of two datagrams, and both are broken.
void SerialUsart::send(SerialPorts& ports) {
    uint32_t lost = 0;
    while (ports.send.next()) {
        if (ports.send.lost() != lost) is_broken_ = true;
        lost = ports.send.lost();
        take(*ports.send);
    }
}

// With what came; a gate may keep some of it back.
std::size_t SerialUsart::fill(std::span<uint8_t> bytes, uint64_t now_us) {
    const auto next = [this](uint8_t& byte) {
        if (taken_ == kTakes || port_.take({&byte, 1}) == 0) return false;
        ++taken_;
        return true;
    };
    if (gate_) return gate_->pass(bytes, now_us, next);
    return port_.take(bytes);
}

void SerialUsart::receive(SerialPorts& ports) {
    taken_ = 0;
    for (unsigned i = 0; i < kPieces; ++i) {
        SerialBytes piece{};
        piece.length = static_cast<uint8_t>(fill(piece.data, ports.now));
        if (!gate_) taken_ += piece.length;
        if (piece.length == 0) break;
        ports.received.publish([&] { return piece; });
    }
    status_.received += taken_;
}

void SerialUsart::report(SerialPorts& ports) {
    const bool signs = gate_ && gate_->signs();
    if (ports.now < next_status_us_ && signs == status_.signs) return;
    if (ports.now >= next_status_us_) next_status_us_ = ports.now + kStatusPeriod_us;
    status_.rx_lost = port_.lost();
    status_.signs = signs;
    ports.status.publish([&] { return status_; });
}

void SerialUsart::step(SerialPorts& ports) {
    if (device_.port == nullptr) start();
    if (gate_) gate_->follow(ports.now);
    send(ports);
    receive(ports);
    report(ports);
}

}  // namespace stator::drivers::serial::usart
