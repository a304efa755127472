// A serial line of a chip as a device of a graph.
#pragma once

#include <optional>
#include <span>

#include "serial_ports.hpp"
#include "stator/mavlink/gate.hpp"
#include "usart_port.hpp"

namespace stator::drivers::serial::usart {

// Datagrams go out whole or not at all: one that finds no room is lost, and counted.
class SerialUsart {
  public:
    using Port = UsartPort<Memory>;
    // The board switches clock and pins on before the graph starts, and its vector calls
    // `interrupt`.
    struct Device {
        uintptr_t base;     // of its registers
        uint32_t clock_hz;  // of its bus
        uint32_t baud;
        // Of signatures of MAVLink frames. Without it, all bytes pass as they are.
        mav::SharedKey* key = nullptr;
        Port* port = nullptr;  // of the node once it runs; a graph without it has no rings
        void interrupt() {
            if (port != nullptr) port->interrupt();
        }
    };

    explicit SerialUsart(Device& device) : device_(device) {}
    void step(SerialPorts& ports);

  private:
    static constexpr unsigned kPieces = 2;       // of one activation: the burst of the output
    static constexpr unsigned kTakes = 128;      // bytes of one activation: as much as they hold
    static constexpr uint32_t kBitsOfByte = 10;  // with start and stop
    static constexpr uint64_t kStatusPeriod_us = 1'000'000;

    void start();
    void send(SerialPorts& ports);
    void take(const SerialBytes& piece);
    void receive(SerialPorts& ports);
    std::size_t fill(std::span<uint8_t> bytes, uint64_t now_us);
    void report(SerialPorts& ports);

    Device& device_;
    Port port_;
    std::optional<mav::Gate> gate_;
    unsigned taken_ = 0;      // bytes, in this activation
    bool is_broken_ = false;  // the datagram whose pieces come
    uint32_t datagram_ = 0;   // its bytes
    uint64_t next_status_us_ = 0;
    SerialStatus status_{};
};

}  // namespace stator::drivers::serial::usart
