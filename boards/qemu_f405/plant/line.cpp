// A serial line of the firmware, passed on to a place of the host.
#include "line.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <span>

namespace stator::plant {

namespace {

// For reading and writing, so that nobody waits for the other side to open it.
int open_fifo(const std::string& path) {
    return ::open(path.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC);
}

}  // namespace

Line::~Line() {
    if (to_firmware_ >= 0) ::close(to_firmware_);
    if (from_firmware_ >= 0) ::close(from_firmware_);
}

std::string Line::open(const char* place, const char* name, uint32_t baud) {
    std::string wrong = port_.open(place);
    if (!wrong.empty()) return wrong;
    to_firmware_ = open_fifo(std::string(name) + ".in");
    from_firmware_ = open_fifo(std::string(name) + ".out");
    if (to_firmware_ < 0 || from_firmware_ < 0) return std::strerror(errno);
    baud_ = baud;
    return {};
}

void Line::move(uint64_t time_us) {
    if (baud_ == 0) return;
    give(time_us);
    take();
}

void Line::give(uint64_t time_us) {
    std::array<uint8_t, kMaxDatagram> bytes;
    for (std::size_t size = 0; (size = port_.receive(bytes)) != 0;) {
        if (waiting_.size() + size > kMostWaits) continue;
        waiting_.insert(waiting_.end(), bytes.begin(), bytes.begin() + size);
    }
    constexpr uint64_t kByte_us = kBitsOfByte * 1'000'000;
    bits_us_ += baud_ * (time_us - last_us_);
    last_us_ = time_us;
    const std::size_t most =
        std::min<std::size_t>({bits_us_ / kByte_us, waiting_.size(), bytes.size()});
    std::copy_n(waiting_.begin(), most, bytes.begin());
    const ssize_t given = most == 0 ? 0 : ::write(to_firmware_, bytes.data(), most);
    if (given > 0) waiting_.erase(waiting_.begin(), waiting_.begin() + given);
    // A line that is idle owes nothing.
    bits_us_ = waiting_.empty()
                   ? 0
                   : bits_us_ - kByte_us * static_cast<uint64_t>(std::max<ssize_t>(given, 0));
}

void Line::take() {
    std::array<uint8_t, kMaxDatagram> bytes;
    const ssize_t got = ::read(from_firmware_, bytes.data(), kMaxDatagram - datagram_.size());
    if (got > 0) datagram_.insert(datagram_.end(), bytes.begin(), bytes.begin() + got);
    const bool is_over = got <= 0 || datagram_.size() == kMaxDatagram;
    if (!is_over || datagram_.empty()) return;
    static_cast<void>(port_.send(datagram_));  // where nobody listens, it is lost
    datagram_.clear();
}

}  // namespace stator::plant
