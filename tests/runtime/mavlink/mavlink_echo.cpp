// Reads frames, one line of hexadecimal digits each, decodes them, and prints them as encoded
// again, or `bad`.
#include <cstdio>
#include <cstdlib>
#include <vector>

#include "mavlink/messages.hpp"
#include "stator/mavlink/parser.hpp"

namespace {

using namespace stator::mav;

void print(std::span<const std::uint8_t> bytes) {
    for (const std::uint8_t byte : bytes) std::printf("%02x", byte);
    std::puts("");
}

void echo(const Frame& frame) {
    for_every_message([&]<class Message>(Message*) {
        if (Message::kId != frame.id) return;
        FrameBytes again;
        again.put(decode<Message>(frame.payload), frame.sequence, frame.source);
        print(again.bytes());
    });
}

}  // namespace

int main() {
    static char line[4096];
    Parser parser(kKnown);
    while (std::scanf("%4095s", line) == 1) {
        std::vector<std::uint8_t> bytes;
        for (const char* hex = line; hex[0] != '\0' && hex[1] != '\0'; hex += 2) {
            const char pair[] = {hex[0], hex[1], '\0'};
            bytes.push_back(static_cast<std::uint8_t>(std::strtoul(pair, nullptr, 16)));
        }
        std::span<const std::uint8_t> rest = bytes;
        const auto frame = parser.next(rest, 0);
        if (frame) {
            echo(*frame);
        } else {
            std::puts("bad");
        }
        std::fflush(stdout);
    }
}
