// What the two ends of a link say to each other: docs/machines.md.
//
// Frames are those of runtime/link. A body begins with a number of the topic and the number of the
// sample on this link; the memory of the message follows, without the padding at its end. A hello
// has a number of its own.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>

namespace stator::machines {

inline constexpr uint8_t kVersion = 1;
inline constexpr uint8_t kHello = 240;  // from here on: not topics
inline constexpr size_t kHeadBytes = 3;

// Of the graph and of its cut at a link; both ends must have the same.
struct Identity {
    uint64_t graph = 0;
    uint64_t cut = 0;
    bool operator==(const Identity&) const = default;
};

struct Hello {
    Identity identity;
    uint32_t boot = 0;   // of the sender
    uint32_t heard = 0;  // of the other end, as the sender has heard it; 0: not heard
};
inline constexpr size_t kHelloBytes = kHeadBytes + 1 + 2 * sizeof(uint64_t) + 2 * sizeof(uint32_t);

// A hello comes at this period until both ends agree, and then once in `kSlowHello`.
inline constexpr uint32_t kSlowHello = 10;
// A peer from which no sound frame came for so long is away.
inline constexpr uint64_t kSilence_us = 1'500'000;

inline void write_head(uint8_t* body, uint8_t topic, uint16_t number) {
    body[0] = topic;
    body[1] = static_cast<uint8_t>(number);
    body[2] = static_cast<uint8_t>(number >> 8);
}
inline uint16_t number_in(const uint8_t* body) {
    return static_cast<uint16_t>(body[1] | (body[2] << 8));
}

inline void write_hello(uint8_t* body, uint16_t number, const Hello& hello) {
    write_head(body, kHello, number);
    uint8_t* at = body + kHeadBytes;
    *at++ = kVersion;
    const auto put = [&at](const auto& value) {
        std::memcpy(at, &value, sizeof value);
        at += sizeof value;
    };
    put(hello.identity.graph);
    put(hello.identity.cut);
    put(hello.boot);
    put(hello.heard);
}
// False: it has another version or length.
[[nodiscard]] inline bool read_hello(const uint8_t* body, size_t count, Hello& hello) {
    if (count != kHelloBytes || body[kHeadBytes] != kVersion) return false;
    const uint8_t* at = body + kHeadBytes + 1;
    const auto get = [&at](auto& value) {
        std::memcpy(&value, at, sizeof value);
        at += sizeof value;
    };
    get(hello.identity.graph);
    get(hello.identity.cut);
    get(hello.boot);
    get(hello.heard);
    return hello.boot != 0;
}

}  // namespace stator::machines
