// A flight whose time goes on as another program says.
#include "lockstep.hpp"

#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <string_view>

#include "world/ending.hpp"

namespace stator::board {

std::string Lockstep::connect(const char* path) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    const std::string_view text = path;
    if (text.size() >= sizeof address.sun_path) {
        return "expected a path of at most " + std::to_string(sizeof address.sun_path - 1) +
               " bytes, found " + std::to_string(text.size());
    }
    std::copy(text.begin(), text.end(), address.sun_path);
    socket_ = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    const auto* const generic = reinterpret_cast<const sockaddr*>(&address);
    if (socket_ >= 0 && ::connect(socket_, generic, sizeof address) == 0) return {};
    const int reason = errno;
    close();
    return std::strerror(reason);
}

void Lockstep::wait() {
    constexpr int kLook_ms = 100;  // for a signal that came just before
    char byte = 0;
    pollfd state{.fd = socket_, .events = POLLIN, .revents = 0};
    while (world::ending_signal.load() == 0) {
        if (::poll(&state, 1, kLook_ms) <= 0) continue;
        const ssize_t got = ::recv(socket_, &byte, 1, 0);
        if (got == 1) return;
        if (got < 0 && errno == EINTR) continue;
        close();
        return;
    }
}

void Lockstep::tell_done() {
    const char byte = '.';
    if (is_open() && ::send(socket_, &byte, 1, MSG_NOSIGNAL) != 1) close();
}

void Lockstep::close() {
    if (socket_ >= 0) ::close(socket_);
    socket_ = -1;
}

}  // namespace stator::board
