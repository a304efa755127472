// A serial line of a chip as a device of a graph.
#include "serial_usart.hpp"

#include <algorithm>
#include <span>

namespace stator::drivers::serial::usart {

void SerialUsart::start() {
    port_.start({device_.base}, device_.clock_hz, device_.baud);
    status_.bytes_per_s = device_.baud / kBitsOfByte;
    device_.port = &port_;
}

void SerialUsart::take(const SerialBytes& piece) {
    const std::size_t length = std::min<std::size_t>(piece.length, piece.data.size());
    datagram_ += static_cast<uint32_t>(length);
    if (!is_broken_) is_broken_ = !port_.add(std::span(piece.data).first(length));
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

void SerialUsart::receive(SerialPorts& ports) {
    for (unsigned i = 0; i < kPieces; ++i) {
        SerialBytes piece{};
        piece.length = static_cast<uint8_t>(port_.take(piece.data));
        if (piece.length == 0) return;
        status_.received += piece.length;
        ports.received.publish([&] { return piece; });
    }
}

void SerialUsart::step(SerialPorts& ports) {
    if (device_.port == nullptr) start();
    send(ports);
    receive(ports);
    if (ports.now < next_status_us_) return;
    next_status_us_ = ports.now + kStatusPeriod_us;
    status_.rx_lost = port_.lost();
    ports.status.publish([&] { return status_; });
}

}  // namespace stator::drivers::serial::usart
