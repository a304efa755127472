// A TCP connection with MAVLink between an autopilot and a simulator.
#include "hil/link.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <string_view>
#include <thread>

#include "world/ending.hpp"

namespace stator::hil {

namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

constexpr milliseconds kLook{100};  // between looks for a signal
constexpr std::chrono::seconds kMostWaits{60};

bool is_ending() {
    return world::ending_signal.load() != 0;
}

bool read_port(std::string_view text, sockaddr_in& address) {
    std::uint16_t port = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), port);
    address.sin_port = htons(port);
    return error == std::errc{} && end == text.data() + text.size() && port != 0;
}

// tcp:[HOST:]PORT
bool read_place(std::string_view place, sockaddr_in& address) {
    constexpr std::string_view kTcp = "tcp:";
    if (!place.starts_with(kTcp)) return false;
    place.remove_prefix(kTcp.size());
    address.sin_family = AF_INET;
    const std::size_t colon = place.find(':');
    if (colon == std::string_view::npos) {
        address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
        return read_port(place, address);
    }
    std::string host(place.substr(0, colon));
    if (host == "localhost") host = "127.0.0.1";
    return inet_pton(AF_INET, host.c_str(), &address.sin_addr) == 1 &&
           read_port(place.substr(colon + 1), address);
}

const sockaddr* generic(const sockaddr_in& address) {
    return reinterpret_cast<const sockaddr*>(&address);
}

int new_socket() {
    return ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
}

// A message is worth more early than together with the next.
void send_at_once(int descriptor) {
    const int yes = 1;
    static_cast<void>(setsockopt(descriptor, IPPROTO_TCP, TCP_NODELAY, &yes, sizeof yes));
}

bool can_read(int descriptor, milliseconds most) {
    pollfd wanted{.fd = descriptor, .events = POLLIN, .revents = 0};
    return poll(&wanted, 1, static_cast<int>(most.count())) > 0;
}

}  // namespace

Link::~Link() {
    close();
}

void Link::close() {
    if (descriptor_ >= 0) ::close(descriptor_);
    descriptor_ = -1;
}

std::string Link::connect(const char* place) {
    sockaddr_in address{};
    if (!read_place(place, address)) return "expected tcp:PORT or tcp:HOST:PORT";
    const auto end = Clock::now() + kMostWaits;
    while (!is_ending()) {
        descriptor_ = new_socket();
        if (descriptor_ < 0) return std::strerror(errno);
        if (::connect(descriptor_, generic(address), sizeof address) == 0) {
            send_at_once(descriptor_);
            return {};
        }
        const int reason = errno;
        close();
        if (reason != ECONNREFUSED && reason != EINTR) return std::strerror(reason);
        if (Clock::now() >= end) return "no simulator listens there (waited for 60 s)";
        std::this_thread::sleep_for(kLook);
    }
    return {};
}

std::string Link::listen(const char* place) {
    sockaddr_in address{};
    if (!read_place(place, address)) return "expected tcp:PORT";
    const int listener = new_socket();
    const int yes = 1;
    const bool listens =
        listener >= 0 && setsockopt(listener, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes) == 0 &&
        bind(listener, generic(address), sizeof address) == 0 && ::listen(listener, 1) == 0;
    std::string wrong = listens ? "" : std::strerror(errno);
    while (listens && descriptor_ < 0 && !is_ending()) {
        if (can_read(listener, kLook))
            descriptor_ = accept4(listener, nullptr, nullptr, SOCK_CLOEXEC);
    }
    if (listener >= 0) ::close(listener);
    if (descriptor_ >= 0) send_at_once(descriptor_);
    return wrong;
}

std::optional<mav::Frame> Link::next(milliseconds most) {
    milliseconds left = most;
    while (is_open() && !is_ending()) {
        // A frame in parts is whole when its last part comes, however late: time does not matter.
        if (auto frame = parser_.next(unread_, 0)) return frame;
        const auto begin = Clock::now();
        const bool has_come = can_read(descriptor_, std::clamp(left, milliseconds{0}, kLook));
        left -= std::chrono::duration_cast<milliseconds>(Clock::now() - begin);
        if (!has_come && left <= milliseconds{0}) return {};
        if (!has_come) continue;
        const ssize_t got = ::recv(descriptor_, buffer_.data(), buffer_.size(), 0);
        if (got < 0 && errno == EINTR) continue;
        if (got <= 0) {
            close();
            return {};
        }
        unread_ = std::span(buffer_).first(static_cast<std::size_t>(got));
    }
    return {};
}

void Link::write(std::span<const std::uint8_t> bytes) {
    while (is_open() && !bytes.empty() && !is_ending()) {
        const ssize_t sent = ::send(descriptor_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
        if (sent >= 0) {
            bytes = bytes.subspan(static_cast<std::size_t>(sent));
        } else if (errno != EINTR) {
            return;  // what the other side had sent before can still be read
        }
    }
}

}  // namespace stator::hil
