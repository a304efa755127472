// The CAN bus of a run.
#include "can_link.hpp"

#include <linux/can.h>
#include <net/if.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>

namespace stator::board {

namespace {

constexpr int kRaw = 1;  // CAN_RAW of <linux/can.h>

int open_socket() {
    return socket(PF_CAN, SOCK_RAW | SOCK_NONBLOCK | SOCK_CLOEXEC, kRaw);
}

}  // namespace

bool is_can_interface(const char* interface) {
    const int descriptor = open_socket();
    if (descriptor < 0) {
        std::fprintf(stderr, "error: this kernel does not support CAN: %s\n", std::strerror(errno));
        return false;
    }
    ::close(descriptor);
    if (std::strlen(interface) < IFNAMSIZ && if_nametoindex(interface) != 0) return true;
    std::fprintf(
        stderr,
        "error: unknown interface '%s'\nhint: to create a virtual one: ip link add %s type "
        "vcan && ip link set %s up\n",
        interface, interface, interface);
    return false;
}

CanLink::~CanLink() {
    if (socket_ >= 0) ::close(socket_);
}

bool CanLink::open(const char* interface) {
    sockaddr_can address{};
    address.can_family = AF_CAN;
    address.can_ifindex = static_cast<int>(if_nametoindex(interface));
    socket_ = open_socket();
    return socket_ >= 0 &&
           bind(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
}

// A frame that finds no room is lost, as a part's own queue would lose it.
void CanLink::send(const dronecan::Frame& frame) const {
    can_frame raw{};
    raw.can_id = frame.id | CAN_EFF_FLAG;
    raw.len = frame.length;
    std::copy(frame.data.begin(), frame.data.end(), raw.data);
    [[maybe_unused]] const ssize_t written = write(socket_, &raw, sizeof raw);
}

bool CanLink::receive(dronecan::Frame& frame) const {
    can_frame raw{};
    while (socket_ >= 0 && read(socket_, &raw, sizeof raw) == sizeof raw) {
        if ((raw.can_id & (CAN_EFF_FLAG | CAN_RTR_FLAG | CAN_ERR_FLAG)) != CAN_EFF_FLAG) continue;
        frame = {.id = raw.can_id & CAN_EFF_MASK, .length = raw.len};
        std::copy_n(raw.data, frame.data.size(), frame.data.begin());
        return true;
    }
    return false;
}

}  // namespace stator::board
