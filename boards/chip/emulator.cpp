#include "emulator.hpp"

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <system_error>

namespace stator::chip {

namespace {

[[noreturn]] void fail(const char* what) {
    throw std::system_error(errno, std::generic_category(), what);
}

}  // namespace

Emulator::Emulator(const std::string& path) {
    sockaddr_un place{};
    place.sun_family = AF_UNIX;
    if (path.size() >= sizeof place.sun_path) {
        errno = ENAMETOOLONG;
        fail("the socket");
    }
    std::ranges::copy(path, place.sun_path);
    const int listener = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    if (listener < 0) fail("socket");
    if (bind(listener, reinterpret_cast<const sockaddr*>(&place), sizeof place) != 0) fail("bind");
    if (listen(listener, 1) != 0) fail("listen");
    socket_ = accept4(listener, nullptr, nullptr, SOCK_CLOEXEC);
    if (socket_ < 0) fail("accept");
    close(listener);
}

Emulator::~Emulator() {
    close(socket_);
}

bool Emulator::take(void* bytes, size_t count) const {
    for (;;) {
        const ssize_t taken = recv(socket_, bytes, count, MSG_WAITALL);
        if (taken == static_cast<ssize_t>(count)) return true;
        if (taken >= 0 || errno != EINTR) return false;
    }
}

// Each system call takes time, so all that is due goes at once.
void Emulator::give(const wire::Reply& reply) {
    flush_stored();
    append(&reply, sizeof reply);
    const uint8_t* from = unsent_.data();
    size_t count = unsent_.size();
    while (count > 0) {
        const ssize_t given = send(socket_, from, count, MSG_NOSIGNAL);
        if (given < 0 && errno == EINTR) continue;
        if (given <= 0) fail("the emulator has ended");
        from += given;
        count -= static_cast<size_t>(given);
    }
    unsent_.clear();
}

void Emulator::append(const void* bytes, size_t count) {
    const auto* from = static_cast<const uint8_t*>(bytes);
    unsent_.insert(unsent_.end(), from, from + count);
}

// Bytes that lie one behind the other are one message.
void Emulator::flush_stored() {
    if (stored_.empty()) return;
    const auto length = static_cast<uint32_t>(stored_.size());
    const uint32_t first = store_end_ - length;
    const wire::Reply ask{.kind = wire::ReplyKind::kStore, .address = first, .length = length};
    append(&ask, sizeof ask);
    append(stored_.data(), stored_.size());
    stored_.clear();
}

void Emulator::fetch(uint32_t address, std::span<uint8_t> bytes) {
    const auto length = static_cast<uint32_t>(bytes.size());
    give({.kind = wire::ReplyKind::kFetch, .address = address, .length = length});
    if (!take(bytes.data(), bytes.size())) fail("the emulator has ended");
}

void Emulator::store(uint32_t address, std::span<const uint8_t> bytes) {
    if (address != store_end_ || stored_.size() + bytes.size() > kMostStored) flush_stored();
    stored_.insert(stored_.end(), bytes.begin(), bytes.end());
    store_end_ = address + static_cast<uint32_t>(bytes.size());
}

void Emulator::stop() {
    give({.kind = wire::ReplyKind::kStop});
}

wire::Reply Emulator::answer(Chip& chip, const wire::Request& request) {
    wire::Reply reply{.kind = wire::ReplyKind::kAnswer};
    switch (request.kind) {
        case wire::RequestKind::kRead:
            reply.value = chip.read(request.address, request.bytes);
            break;
        case wire::RequestKind::kWrite:
            chip.write(request.address, request.value, request.bytes);
            break;
        case wire::RequestKind::kReset:
            if (has_started_) {
                ++resets_;
                chip.reset();
            }
            has_started_ = true;
            break;
        case wire::RequestKind::kDue:
            break;
    }
    reply.reset = chip.take_reset_request() ? 1 : 0;
    reply.levels = chip.levels();
    reply.core_hz = chip.clocks().core_hz;
    return reply;
}

void Emulator::serve(Chip& chip, const std::function<bool()>& is_over) {
    wire::Request request{};
    while (take(&request, sizeof request)) {
        wire::Reply reply;
        ++requests_;
        try {
            chip.move(request.now_ns);
            reply = answer(chip, request);
        } catch (const Violation&) {
            give({.kind = wire::ReplyKind::kStop, .value = 1});
            throw;
        }
        if (is_over()) return;
        reply.next_ns = chip.visible_ns();
        reply.known = chip.known(reply.next_ns);
        give(reply);
    }
}

}  // namespace stator::chip
