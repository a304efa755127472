// Reads lines `TYPE HEX`, decodes the payload, and prints it as encoded again, or `bad`. TYPE is
// the kind (0 message, 1 request, 2 response) and the id of a type.
#include <cstdio>
#include <cstdlib>
#include <vector>

#include "every_type.hpp"

namespace {

using namespace stator::dronecan;

template <class Message>
void echo(const std::vector<std::uint8_t>& payload) {
    Message message;
    if (!decode(payload, message)) {
        std::puts("bad");
        return;
    }
    std::array<std::uint8_t, Message::kType.most_bytes> bytes;
    const std::size_t length = encode(message, bytes);
    for (std::size_t i = 0; i < length; ++i) std::printf("%02x", bytes[i]);
    std::puts("");
}

std::vector<std::uint8_t> bytes_of(const char* hex) {
    std::vector<std::uint8_t> bytes;
    for (; hex[0] != '\0' && hex[1] != '\0'; hex += 2) {
        const char pair[] = {hex[0], hex[1], '\0'};
        bytes.push_back(static_cast<std::uint8_t>(std::strtoul(pair, nullptr, 16)));
    }
    return bytes;
}

}  // namespace

int main() {
    static char hex[4096];
    unsigned kind = 0;
    unsigned id = 0;
    while (std::scanf("%u %u", &kind, &id) == 2) {
        if (std::fgets(hex, sizeof hex, stdin) == nullptr) return 1;
        const std::vector<std::uint8_t> payload = bytes_of(hex + 1);  // behind the blank
        for_every_type([&]<class Message>(Message*) {
            if (Message::kType.id == id && static_cast<unsigned>(Message::kType.kind) == kind) {
                echo<Message>(payload);
            }
        });
        std::fflush(stdout);
    }
}
