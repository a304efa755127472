// A socket or a terminal of a host as a serial line.
#include "serial_socket.hpp"

#include <algorithm>

#include "mavlink/messages.hpp"

namespace stator::drivers::serial::socket {

// A datagram that grows too long, or of which a piece was lost, does not go out.
void SerialSocket::take(const SerialBytes& piece) {
    const std::size_t length = std::min<std::size_t>(piece.length, piece.data.size());
    if (piece.adopts) {
        if (gate_) gate_->adopt(std::span(piece.data).first(length));
        return;
    }
    if (length > out_.size() - out_size_) {
        status_.tx_lost += static_cast<uint32_t>(out_size_ + length);
        out_size_ = 0;
        return;
    }
    std::copy_n(piece.data.begin(), length, out_.begin() + static_cast<std::ptrdiff_t>(out_size_));
    out_size_ += length;
    if (!piece.ends) return;
    if (gate_) gate_->sign(std::span(out_).first(out_size_), true);
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

// With what came; a gate may keep some of it back.
std::size_t SerialSocket::fill(std::span<uint8_t> bytes, uint64_t now_us) {
    const auto next = [this](uint8_t& byte) {
        if (in_done_ == in_size_ || taken_ == kTakes) return false;
        ++taken_;
        byte = in_[in_done_++];
        return true;
    };
    if (gate_) return gate_->pass(bytes, now_us, next);
    std::size_t count = 0;
    while (count < bytes.size() && next(bytes[count])) ++count;
    return count;
}

void SerialSocket::receive(SerialPorts& ports) {
    read_all();
    taken_ = 0;
    for (unsigned i = 0; i < kPieces; ++i) {
        SerialBytes piece{};
        piece.length = static_cast<uint8_t>(fill(piece.data, ports.now));
        if (piece.length == 0) return;
        ports.received.publish([&] { return piece; });
    }
}

void SerialSocket::send(SerialPorts& ports) {
    uint32_t lost = 0;
    while (ports.send.next()) {
        if (ports.send.lost() != lost) out_size_ = 0;
        lost = ports.send.lost();
        take(*ports.send);
    }
}

void SerialSocket::report(SerialPorts& ports) {
    const bool signs = gate_ && gate_->signs();
    if (ports.now < next_status_us_ && signs == status_.signs) return;
    if (ports.now >= next_status_us_) next_status_us_ = ports.now + kStatusPeriod_us;
    status_.bytes_per_s = port_.bytes_per_s();
    status_.signs = signs;
    ports.status.publish([&] { return status_; });
}

void SerialSocket::step(SerialPorts& ports) {
    if (!port_.is_open()) return;
    if (!gate_ && port_.key() != nullptr) gate_.emplace(*port_.key(), mav::kKnown);
    if (gate_) gate_->follow(ports.now);
    send(ports);
    receive(ports);
    report(ports);
}

}  // namespace stator::drivers::serial::socket
