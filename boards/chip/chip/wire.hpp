// The two messages between the emulator and the model of its chip. The machine of the emulator lays
// them out the same way (boards/qemu_machine/stm32f427.c).
#pragma once

#include <array>
#include <cstdint>

namespace stator::chip::wire {

enum class RequestKind : uint8_t { kRead, kWrite, kDue, kReset };
struct Request {
    RequestKind kind;
    uint8_t bytes;
    uint16_t unused;
    uint32_t address;
    uint64_t now_ns;
    uint32_t value;
    uint32_t unused2;
};
static_assert(sizeof(Request) == 24);

// A register that counts by itself, which the emulator reads without asking, up to a time: `first`
// at `from_ns`, and one more each `divider` clocks of `clock_hz`. Divider 0: none.
struct Counter {
    uint32_t address = 0;
    uint32_t first = 0;
    uint32_t clock_hz = 0;
    uint32_t divider = 0;
    uint64_t from_ns = 0;
    uint64_t until_ns = 0;
};
static_assert(sizeof(Counter) == 32);
using Known = std::array<Counter, 2>;

// kFetch and kStore read and write the machine's memory; they come before the answer.
enum class ReplyKind : uint32_t { kAnswer, kFetch, kStore, kStop };
struct Reply {
    ReplyKind kind{};
    uint32_t value = 0;
    uint32_t address = 0;
    uint32_t length = 0;
    std::array<uint32_t, 3> levels{};
    uint32_t core_hz = 0;
    uint64_t next_ns = 0;
    uint32_t reset = 0;
    uint32_t unused = 0;
    Known known{};
};
static_assert(sizeof(Reply) == 112);

}  // namespace stator::chip::wire
