// One end of a flooded bus: sends numbered frames at a rate through the SocketCAN driver, takes
// those of the other end, and prints counts. can_flood INTERFACE OWN_ID OTHER_ID FRAMES_A_SECOND
// SECONDS
//
// It listens until the other end's last frame, or until that has been silent for 20 s.
#include <poll.h>
#include <time.h>

#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "socket_port.hpp"

namespace {

using namespace stator;
using drivers::can::CanSend;
using drivers::can::socketcan::SocketPort;

constexpr std::uint32_t kLast = 16;
int descriptor = -1;

std::uint64_t clock_us() {
    timespec now{};
    clock_gettime(CLOCK_MONOTONIC, &now);
    return static_cast<std::uint64_t>(now.tv_sec) * 1'000'000 +
           static_cast<std::uint64_t>(now.tv_nsec) / 1000;
}

struct Counts {
    std::uint32_t sent = 0;
    std::uint32_t full = 0;
    std::uint32_t received = 0;
    std::uint32_t before = 0;
    std::uint32_t missing = 0;  // by their numbers
    std::uint32_t disordered = 0;
    std::uint32_t next = 0;  // number of the other end
    std::uint64_t heard_us = 0;
};

void take(SocketPort& port, std::uint32_t other, std::uint64_t now_us, Counts& counts) {
    for (CanFrame frame; port.receive(frame, now_us);) {
        if (frame.id != other) continue;
        std::uint32_t number = 0;
        std::memcpy(&number, frame.data.data(), sizeof number);
        // Those before the first one were sent before this end was there.
        if (counts.received++ == 0) counts.before = counts.next = number;
        counts.heard_us = now_us;
        if (number < counts.next) {
            ++counts.disordered;
            continue;
        }
        counts.missing += number - counts.next;
        counts.next = number + 1;
    }
}

void send_due(SocketPort& port, std::uint32_t own, std::uint64_t due, Counts& counts) {
    // A few at a time: who is late must not stop listening to catch up.
    for (int i = 0; i < 8 && counts.sent < due; ++i) {
        CanFrame frame{.id = own, .extended = true, .length = 8};
        std::memcpy(frame.data.data(), &counts.sent, sizeof counts.sent);
        if (port.send(frame) != CanSend::kSent) {
            ++counts.full;
            return;
        }
        ++counts.sent;
    }
}

}  // namespace

int main(int count, char** arguments) {
    if (count != 6) return 2;
    const auto number = [&](int i) {
        return static_cast<std::uint32_t>(std::strtoul(arguments[i], nullptr, 0));
    };
    SocketPort::Device device{.interface = arguments[1]};
    device.watch = [](int opened) { descriptor = opened; };
    SocketPort port(device);
    Counts counts;
    const std::uint64_t total = std::uint64_t{number(4)} * number(5);
    const std::uint64_t begin_us = clock_us();
    std::uint64_t flood_end_us = begin_us;
    counts.heard_us = begin_us + 8'000'000;  // how long the other end may take to start
    for (std::uint64_t now_us = begin_us;; now_us = clock_us()) {
        port.begin(now_us);
        // The last frames go out one by one, while the other end catches up: the kernel tells of
        // losses with the next frame that it keeps.
        const std::uint64_t due = (now_us - begin_us) * number(4) / 1'000'000;
        if (counts.sent + kLast < total) flood_end_us = now_us;
        const std::uint64_t alone = (now_us - flood_end_us) / 500'000;
        const std::uint64_t most = total - kLast + (alone < kLast ? alone : kLast);
        send_due(port, number(2), due < most ? due : most, counts);
        take(port, number(3), now_us, counts);
        const bool silent = now_us > counts.heard_us && now_us - counts.heard_us > 20'000'000;
        if (counts.sent == total && (silent || counts.next == total)) break;
        pollfd waiting{descriptor, POLLIN, 0};
        poll(&waiting, 1, 1);
    }
    CanInterfaceStatus status{};
    port.count(status);
    std::printf("{\"sent\": %u, \"full\": %u, \"received\": %u, \"before\": %u, ", counts.sent,
                counts.full, counts.received, counts.before);
    std::printf("\"missing\": %u, \"disordered\": %u, \"rx_lost\": %u}\n", counts.missing,
                counts.disordered, status.rx_lost);
}
