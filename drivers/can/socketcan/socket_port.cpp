// A CAN interface of Linux. Behaviour of raw sockets: the kernel's
// Documentation/networking/can.rst.
#include "socket_port.hpp"

#include <linux/can.h>
#include <linux/can/error.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <ctime>

namespace stator::drivers::can::socketcan {

namespace {

constexpr uint64_t kReopenPeriod_us = 100'000;
constexpr int kReceiveBytes = 1 << 20;  // room for some 2,000 frames, as the kernel counts them

template <class Value>
bool set(int descriptor, int level, int option, const Value& value) {
    return setsockopt(descriptor, level, option, &value, sizeof value) == 0;
}

// Nothing is waited for: sends and receives say EAGAIN.
int open_socket() {
    return ::socket(PF_CAN, SOCK_RAW | SOCK_NONBLOCK | SOCK_CLOEXEC, CAN_RAW);
}

bool is_up(int descriptor, const char* name) {
    ifreq request{};
    std::strncpy(request.ifr_name, name, IFNAMSIZ - 1);
    return ioctl(descriptor, SIOCGIFFLAGS, &request) == 0 && (request.ifr_flags & IFF_UP) != 0;
}

// How long ago the kernel saw the frame, by its clock of the day; by ours, that is `speed` times so
// long.
uint64_t age_us(const timespec& seen, const timespec& now, double speed) {
    const int64_t age_ns =
        (now.tv_sec - seen.tv_sec) * 1'000'000'000LL + (now.tv_nsec - seen.tv_nsec);
    constexpr int64_t kMax_ns = 1'000'000'000;  // more, or less than none: that clock was set
    if (age_ns <= 0 || age_ns >= kMax_ns) return 0;
    return static_cast<uint64_t>(speed * static_cast<double>(age_ns / 1000));
}

}  // namespace

bool SocketPort::open() {
    socket_ = open_socket();
    if (socket_ < 0) return false;
    ifreq request{};
    std::strncpy(request.ifr_name, device_.interface, IFNAMSIZ - 1);
    sockaddr_can address{};
    address.can_family = AF_CAN;
    const bool there =
        is_up(socket_, device_.interface) && ioctl(socket_, SIOCGIFINDEX, &request) == 0;
    address.can_ifindex = request.ifr_ifindex;
    std::array<can_filter, Device::kMaxFilters> filters{};
    // Without CAN_ERR_FLAG: a mask with it would ask for error frames only.
    filters[0] = {.can_id = 0, .can_mask = CAN_RTR_FLAG};
    const unsigned count = std::clamp(device_.filter_count, 1U, Device::kMaxFilters);
    for (unsigned i = 0; i < device_.filter_count && i < filters.size(); ++i) {
        filters[i] = {.can_id = device_.filters[i].id, .can_mask = device_.filters[i].mask};
    }
    const can_err_mask_t errors = CAN_ERR_MASK;
    const bool ready =
        there &&
        setsockopt(socket_, SOL_CAN_RAW, CAN_RAW_FILTER, filters.data(),
                   static_cast<socklen_t>(count * sizeof(can_filter))) == 0 &&
        set(socket_, SOL_CAN_RAW, CAN_RAW_ERR_FILTER, errors) &&
        set(socket_, SOL_SOCKET, SO_TIMESTAMPNS, 1) && set(socket_, SOL_SOCKET, SO_RXQ_OVFL, 1) &&
        bind(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
    // What an ordinary user may have is less, and a longer wish is cut to that.
    if (!set(socket_, SOL_SOCKET, SO_RCVBUFFORCE, kReceiveBytes)) {
        set(socket_, SOL_SOCKET, SO_RCVBUF, kReceiveBytes);
    }
    if (ready) return true;
    ::close(socket_);
    socket_ = -1;
    return false;
}

void SocketPort::close() {
    if (device_.unwatch != nullptr) device_.unwatch();
    ::close(socket_);
    socket_ = -1;
    rx_lost_before_ += rx_lost_;
    rx_lost_ = 0;
    state_ = State::kDown;
}

void SocketPort::begin(uint64_t now_us) {
    if (socket_ >= 0 || device_.interface == nullptr || now_us < next_open_us_) return;
    next_open_us_ = now_us + kReopenPeriod_us;
    if (!open()) return;
    state_ = State::kErrorActive;
    if (device_.watch != nullptr) device_.watch(socket_);
}

// The interface is down or gone: the socket is opened again when it is back.
void SocketPort::fail(int error) {
    if (error == EAGAIN || error == EINTR || error == ENOBUFS) return;
    ++io_errors_;
    close();
}

CanSend SocketPort::send(const CanFrame& frame) {
    if (socket_ < 0 || state_ == State::kBusOff) return CanSend::kFull;
    can_frame raw{};
    raw.can_id = frame.id | (frame.extended ? CAN_EFF_FLAG : 0);
    raw.len = frame.length;
    std::copy(frame.data.begin(), frame.data.end(), raw.data);
    if (write(socket_, &raw, sizeof raw) == sizeof raw) return CanSend::kSent;
    fail(errno);  // ENOBUFS: the interface's own queue is full
    return CanSend::kFull;
}

// Takes as many frames from the kernel as one call gives; false if there are none.
bool SocketPort::fetch(uint64_t now_us) {
    struct Raw {
        can_frame frame;
        alignas(cmsghdr) char control[CMSG_SPACE(sizeof(timespec)) + CMSG_SPACE(sizeof(uint32_t))];
    };
    std::array<Raw, kMaxFetched> raw{};
    std::array<iovec, kMaxFetched> parts{};
    std::array<mmsghdr, kMaxFetched> messages{};
    for (unsigned i = 0; i < kMaxFetched; ++i) {
        parts[i] = {&raw[i].frame, sizeof raw[i].frame};
        messages[i].msg_hdr.msg_iov = &parts[i];
        messages[i].msg_hdr.msg_iovlen = 1;
        messages[i].msg_hdr.msg_control = raw[i].control;
        messages[i].msg_hdr.msg_controllen = sizeof raw[i].control;
    }
    const int count = recvmmsg(socket_, messages.data(), kMaxFetched, 0, nullptr);
    if (count < 0) {
        fail(errno);
        return false;
    }
    timespec now{};
    clock_gettime(CLOCK_REALTIME, &now);
    for (int i = 0; i < count; ++i) {
        mmsghdr& message = messages[static_cast<unsigned>(i)];
        const can_frame& frame = raw[static_cast<unsigned>(i)].frame;
        timespec seen = now;
        for (cmsghdr* c = CMSG_FIRSTHDR(&message.msg_hdr); c != nullptr;
             c = CMSG_NXTHDR(&message.msg_hdr, c)) {
            if (c->cmsg_level != SOL_SOCKET) continue;
            if (c->cmsg_type == SCM_TIMESTAMPNS) std::memcpy(&seen, CMSG_DATA(c), sizeof seen);
            if (c->cmsg_type == SO_RXQ_OVFL) {
                std::memcpy(&rx_lost_, CMSG_DATA(c), sizeof rx_lost_);
            }
        }
        const uint64_t age = age_us(seen, now, device_.clock_speed);
        sort(frame, message.msg_len == sizeof frame, now_us > age ? now_us - age : 0);
    }
    return true;
}

// Keeps a data frame, reports an error frame, and counts any other.
void SocketPort::sort(const can_frame& raw, bool is_whole, uint64_t seen_us) {
    if ((raw.can_id & CAN_ERR_FLAG) != 0) {
        take_error_frame(raw.can_id, raw.data);
        return;
    }
    if (!is_whole || raw.len > sizeof raw.data || (raw.can_id & CAN_RTR_FLAG) != 0) {
        ++rx_ignored_;
        return;
    }
    const bool extended = (raw.can_id & CAN_EFF_FLAG) != 0;
    CanFrame& frame = fetched_[fetched_count_++];
    frame = {.timestamp_sample = seen_us,
             .id = raw.can_id & (extended ? CAN_EFF_MASK : CAN_SFF_MASK),
             .extended = extended,
             .length = raw.len};
    std::copy_n(raw.data, frame.data.size(), frame.data.begin());
}

bool SocketPort::receive(CanFrame& frame, uint64_t now_us) {
    if (taken_ == fetched_count_) {
        taken_ = 0;
        fetched_count_ = 0;
        // Once an activation: what is left raises the line again.
        if (socket_ < 0 || fetched_us_ == now_us || !fetch(now_us)) return false;
        fetched_us_ = now_us;
        if (fetched_count_ == 0) return false;
    }
    frame = fetched_[taken_++];
    return true;
}

// <linux/can/error.h>. The state of the controller is the last one reported.
void SocketPort::take_error_frame(uint32_t kind, const uint8_t* data) {
    if ((kind & CAN_ERR_BUSOFF) != 0) {
        ++bus_off_count_;
        state_ = State::kBusOff;
        return;
    }
    if ((kind & CAN_ERR_RESTARTED) != 0) state_ = State::kErrorActive;
    if ((kind & CAN_ERR_CRTL) != 0) {
        if ((data[1] & CAN_ERR_CRTL_RX_OVERFLOW) != 0) ++rx_overflows_;
        constexpr uint8_t kPassive = CAN_ERR_CRTL_RX_PASSIVE | CAN_ERR_CRTL_TX_PASSIVE;
        constexpr uint8_t kWarning = CAN_ERR_CRTL_RX_WARNING | CAN_ERR_CRTL_TX_WARNING;
        if ((data[1] & CAN_ERR_CRTL_ACTIVE) != 0) state_ = State::kErrorActive;
        if ((data[1] & kWarning) != 0) state_ = State::kErrorWarning;
        if ((data[1] & kPassive) != 0) state_ = State::kErrorPassive;
    }
    if ((kind & ~(CAN_ERR_FLAG | CAN_ERR_RESTARTED)) != 0) ++io_errors_;
}

void SocketPort::count(CanInterfaceStatus& status) const {
    status.io_errors = io_errors_;
    status.rx_lost = rx_lost_before_ + rx_lost_ + rx_overflows_;
    status.rx_ignored = rx_ignored_;
    status.bus_off_count = bus_off_count_;
}

}  // namespace stator::drivers::can::socketcan
