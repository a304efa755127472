// A socket or a terminal of a host as a serial line.
#pragma once

#include <array>
#include <optional>

#include "port.hpp"
#include "serial_ports.hpp"
#include "stator/mavlink/gate.hpp"

namespace stator::drivers::serial::socket {

// In each activation it takes what has come from the system, and publishes as much as the burst of
// the output has room for: what comes faster for longer is lost, datagram by datagram, so that what
// is passed on is new. What is to be sent goes out at the end of a datagram.
class SerialSocket {
  public:
    // The board opens it; closed, the driver does nothing.
    using Device = Port;

    explicit SerialSocket(Device& device) : port_(device) {}
    void step(SerialPorts& ports);

  private:
    static constexpr unsigned kPieces = 2;   // of one activation: the burst of the output
    static constexpr unsigned kTakes = 128;  // bytes of one activation: as much as they hold
    static constexpr std::size_t kMaxDatagram = 2048;
    static constexpr uint64_t kStatusPeriod_us = 1'000'000;

    static constexpr unsigned kReadsAtOnce = 64;

    void take(const SerialBytes& piece);
    void send(SerialPorts& ports);
    void receive(SerialPorts& ports);
    void read_all();
    std::size_t fill(std::span<uint8_t> bytes, uint64_t now_us);
    void report(SerialPorts& ports);

    Port& port_;
    std::optional<mav::Gate> gate_;
    unsigned taken_ = 0;  // bytes of `in_`, in this activation
    std::array<uint8_t, 2 * kMaxDatagram> in_{};
    std::size_t in_size_ = 0;
    std::size_t in_done_ = 0;
    std::array<uint8_t, kMaxDatagram> out_{};
    std::size_t out_size_ = 0;
    uint64_t next_status_us_ = 0;
    SerialStatus status_{};
};

}  // namespace stator::drivers::serial::socket
