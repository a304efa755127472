// A UDP or TCP socket, or a serial line of this machine.
#include "port.hpp"

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <string_view>
#include <vector>

namespace stator::drivers::serial::socket {

namespace {

constexpr const char* kForms = "expected udp:[HOST:]PORT, tcp:PORT or serial:PATH:BAUD";
// What an activation each 10 ms can pass on, with some left over.
constexpr uint32_t kSocketBytesPerS = 48'000;
constexpr uint32_t kBitsOfByte = 10;  // with start and stop

std::vector<std::string> split(std::string_view text) {
    std::vector<std::string> parts{""};
    for (const char c : text) {
        if (c == ':') {
            parts.emplace_back();
        } else {
            parts.back() += c;
        }
    }
    return parts;
}

template <class Number>
bool read(const std::string& text, Number& number) {
    const char* const end = text.data() + text.size();
    const auto [stop, error] = std::from_chars(text.data(), end, number);
    return error == std::errc{} && stop == end && number != 0;
}

sockaddr_in loopback(uint16_t port) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(port);
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    return address;
}

const sockaddr* generic(const sockaddr_in& address) {
    return reinterpret_cast<const sockaddr*>(&address);
}

}  // namespace

Port::~Port() {
    if (descriptor_ >= 0) ::close(descriptor_);
    if (listener_ >= 0) ::close(listener_);
}

std::string Port::open(const char* place) {
    const std::vector<std::string> parts = split(place);
    uint16_t port = 0;
    if (parts[0] == "udp" && parts.size() == 3 && read(parts[2], port)) {
        return open_udp(parts[1], port);
    }
    if (parts[0] == "udp" && parts.size() == 2 && read(parts[1], port)) {
        return open_udp("127.0.0.1", port);
    }
    if (parts[0] == "tcp" && parts.size() == 2 && read(parts[1], port)) return open_tcp(port);
    uint32_t baud = 0;
    if (parts[0] == "serial" && parts.size() == 3 && read(parts[2], baud)) {
        return open_serial(parts[1], baud);
    }
    return kForms;
}

// On loopback nobody else's machine can write to it.
std::string Port::open_udp(const std::string& host, uint16_t port) {
    sockaddr_in peer = loopback(port);
    if (host != "localhost" && inet_pton(AF_INET, host.c_str(), &peer.sin_addr) != 1) {
        return "expected an IPv4 address, found '" + host + "'";
    }
    descriptor_ = ::socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
    if (descriptor_ < 0) return std::strerror(errno);
    sockaddr_in own = loopback(0);
    const bool is_near = ntohl(peer.sin_addr.s_addr) >> 24 == IN_LOOPBACKNET;
    if (!is_near) own.sin_addr.s_addr = htonl(INADDR_ANY);
    if (bind(descriptor_, generic(own), sizeof own) != 0) return std::strerror(errno);
    peers_[0] = {.address = peer.sin_addr.s_addr, .port = peer.sin_port};
    peer_count_ = 1;
    bytes_per_s_ = kSocketBytesPerS;
    kind_ = Kind::kUdp;
    return {};
}

std::string Port::open_tcp(uint16_t port) {
    listener_ = ::socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
    const int yes = 1;
    const sockaddr_in own = loopback(port);
    const bool listens =
        listener_ >= 0 && setsockopt(listener_, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes) == 0 &&
        bind(listener_, generic(own), sizeof own) == 0 && listen(listener_, 1) == 0;
    if (!listens) return std::strerror(errno);
    bytes_per_s_ = kSocketBytesPerS;
    kind_ = Kind::kTcp;
    return {};
}

// Whoever starts the program has set the line to raw bytes and to this rate.
std::string Port::open_serial(const std::string& path, uint32_t baud) {
    descriptor_ = ::open(path.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
    if (descriptor_ < 0) return std::strerror(errno);
    bytes_per_s_ = std::min(baud / kBitsOfByte, kSocketBytesPerS);
    kind_ = Kind::kSerial;
    return {};
}

// The newest ones that wrote, in turns, and always the one that was given.
void Port::remember(const Peer& peer) {
    for (unsigned i = 0; i < peer_count_; ++i) {
        if (peers_[i] == peer) return;
    }
    peers_[next_peer_] = peer;
    peer_count_ = std::max(peer_count_, next_peer_ + 1);
    next_peer_ = next_peer_ + 1 == kPeers ? 1 : next_peer_ + 1;
}

void Port::accept_client() {
    descriptor_ = ::accept4(listener_, nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC);
}

void Port::close_client() {
    ::close(descriptor_);
    descriptor_ = -1;
}

std::size_t Port::receive(std::span<uint8_t> bytes) {
    if (kind_ == Kind::kTcp && descriptor_ < 0) accept_client();
    if (descriptor_ < 0) return 0;
    if (kind_ == Kind::kUdp) {
        sockaddr_in from{};
        socklen_t length = sizeof from;
        const ssize_t got = recvfrom(descriptor_, bytes.data(), bytes.size(), 0,
                                     reinterpret_cast<sockaddr*>(&from), &length);
        if (got <= 0) return 0;  // also: nobody listens where we sent to
        remember({.address = from.sin_addr.s_addr, .port = from.sin_port});
        return static_cast<std::size_t>(got);
    }
    const ssize_t got = ::read(descriptor_, bytes.data(), bytes.size());
    const bool is_gone = got == 0 || (got < 0 && errno != EAGAIN && errno != EINTR);
    if (kind_ == Kind::kTcp && is_gone) close_client();
    return got > 0 ? static_cast<std::size_t>(got) : 0;
}

bool Port::send(std::span<const uint8_t> bytes) {
    if (kind_ == Kind::kUdp) {
        bool is_sent = false;
        for (unsigned i = 0; i < peer_count_; ++i) {
            sockaddr_in to{};
            to.sin_family = AF_INET;
            to.sin_addr.s_addr = peers_[i].address;
            to.sin_port = peers_[i].port;
            const ssize_t sent = sendto(descriptor_, bytes.data(), bytes.size(), MSG_NOSIGNAL,
                                        generic(to), sizeof to);
            is_sent = is_sent || sent == static_cast<ssize_t>(bytes.size());
        }
        return is_sent;
    }
    if (descriptor_ < 0) return false;
    const ssize_t sent = kind_ == Kind::kTcp
                             ? ::send(descriptor_, bytes.data(), bytes.size(), MSG_NOSIGNAL)
                             : ::write(descriptor_, bytes.data(), bytes.size());
    return sent == static_cast<ssize_t>(bytes.size());
}

}  // namespace stator::drivers::serial::socket
