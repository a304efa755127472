// A place where bytes come from and go to: a UDP or TCP socket, or a serial line of this machine.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "stator/mavlink/shared_key.hpp"

namespace stator::drivers::serial::socket {

// Nothing waits: what cannot be done at once is not done. One thread.
class Port {
  public:
    Port() = default;
    ~Port();
    Port(const Port&) = delete;
    Port& operator=(const Port&) = delete;

    // "udp:HOST:PORT" sends there, and to the last others that wrote to it; "tcp:PORT" listens on
    // 127.0.0.1, for one client at a time; "serial:PATH:BAUD". Empty: done. Else what is wrong.
    [[nodiscard]] std::string open(const char* place);

    // The key of signatures of MAVLink frames. Without it, all bytes pass as they are.
    void use(mav::SharedKey& key) { key_ = &key; }
    mav::SharedKey* key() const { return key_; }

    bool is_open() const { return kind_ != Kind::kNone; }
    uint32_t bytes_per_s() const { return bytes_per_s_; }
    // One datagram, or what has come; 0: nothing.
    std::size_t receive(std::span<uint8_t> bytes);
    [[nodiscard]] bool send(std::span<const uint8_t> bytes);

  private:
    struct Peer {
        uint32_t address = 0;  // both in the network's order
        uint16_t port = 0;
        bool operator==(const Peer&) const = default;
    };
    enum class Kind : uint8_t { kNone, kUdp, kTcp, kSerial };
    static constexpr unsigned kPeers = 4;

    std::string open_udp(const std::string& host, uint16_t port);
    std::string open_tcp(uint16_t port);
    std::string open_serial(const std::string& path, uint32_t baud);
    void remember(const Peer& peer);
    void accept_client();
    void close_client();

    mav::SharedKey* key_ = nullptr;
    Kind kind_ = Kind::kNone;
    int descriptor_ = -1;  // of UDP, of the client of TCP, of the serial line
    int listener_ = -1;    // of TCP
    uint32_t bytes_per_s_ = 0;
    std::array<Peer, kPeers> peers_{};  // of UDP; the first is the one that was given
    unsigned peer_count_ = 0;
    unsigned next_peer_ = 1;
};

}  // namespace stator::drivers::serial::socket
