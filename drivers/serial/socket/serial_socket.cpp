// A socket or a terminal of a host as a serial line.
#include "serial_socket.hpp"

#include <algorithm>

namespace stator::drivers::serial::socket {

// A datagram that grows too long, or of which a piece was lost, does not go out.
void SerialSocket::take(const SerialBytes& piece) {
    const std::size_t length = std::min<std::size_t>(piece.length, piece.data.size());
    if (length > out_.size() - out_size_) {
        status_.tx_lost += static_cast<uint32_t>(out_size_ + length);
        out_size_ = 0;
        return;
    }
    std::copy_n(piece.data.begin(), length, out_.begin() + static_cast<std::ptrdiff_t>(out_size_));
    out_size_ += length;
    if (!piece.ends) return;
    const bool is_sent = port_.send(std::span(out_).first(out_size_));
    (is_sent ? status_.sent : status_.tx_lost) += static_cast<uint32_t>(out_size_);
    out_size_ = 0;
}

// Datagrams that find no room are lost.
void SerialSocket::read_all() {
    std::copy(in_.begin() + static_cast<std::ptrdiff_t>(in_done_),
              in_.begin() + static_cast<std::ptrdiff_t>(in_size_), in_.begin());
    in_size_ -= in_done_;
    in_done_ = 0;
    std::array<uint8_t, kMaxDatagram> datagram;
    for (unsigned i = 0; i < kReadsAtOnce; ++i) {
        const std::size_t size = port_.receive(datagram);
        if (size == 0) return;
        const bool fits = size <= in_.size() - in_size_;
        (fits ? status_.received : status_.rx_lost) += static_cast<uint32_t>(size);
        if (!fits) continue;
        std::copy_n(datagram.begin(), size, in_.begin() + static_cast<std::ptrdiff_t>(in_size_));
        in_size_ += size;
    }
}

void SerialSocket::receive(SerialPorts& ports) {
    read_all();
    for (unsigned i = 0; i < kPieces && in_done_ < in_size_; ++i) {
        ports.received.publish([&] {
            SerialBytes piece{};
            const std::size_t length = std::min(in_size_ - in_done_, piece.data.size());
            std::copy_n(in_.begin() + static_cast<std::ptrdiff_t>(in_done_), length,
                        piece.data.begin());
            in_done_ += length;
            piece.length = static_cast<uint8_t>(length);
            return piece;
        });
    }
}

void SerialSocket::step(SerialPorts& ports) {
    if (!port_.is_open()) return;
    uint32_t lost = 0;
    while (ports.send.next()) {
        if (ports.send.lost() != lost) out_size_ = 0;
        lost = ports.send.lost();
        take(*ports.send);
    }
    receive(ports);
    if (ports.now < next_status_us_) return;
    next_status_us_ = ports.now + kStatusPeriod_us;
    status_.bytes_per_s = port_.bytes_per_s();
    ports.status.publish([&] { return status_; });
}

}  // namespace stator::drivers::serial::socket
