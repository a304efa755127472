#include "wrecker.hpp"

#include <array>
#include <cstring>

#include "stator/executor.hpp"

namespace stator::apps::wrecker {

namespace {

[[gnu::noinline]] void read_null(const volatile uint32_t* pointer) {
    static_cast<void>(pointer[1]);
}

[[gnu::noinline]] void write_code() {
    *reinterpret_cast<volatile uint32_t*>(0x08001000) = 0;
}

[[gnu::noinline]] void run_data() {
    static const std::array<uint16_t, 2> kReturn{0x4770, 0x4770};  // bx lr
    static std::array<uint16_t, 2> code;
    code = kReturn;
    reinterpret_cast<void (*)()>(reinterpret_cast<uintptr_t>(code.data()) | 1U)();
}

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Winfinite-recursion"
[[gnu::noinline]] uint32_t recurse(volatile uint32_t* before) {
    volatile uint32_t here[16] = {*before};
    return recurse(here) + here[0];
}
#pragma GCC diagnostic pop

[[gnu::noinline]] void divide() {
    volatile int number = 1;
    volatile int zero = 0;
    number = number / zero;
}

[[gnu::noinline]] void never_end() {
    while (true) asm volatile("");
}

}  // namespace

bool was_told(const char* word) {
    static std::array<char, 256> text{};
    std::array<uintptr_t, 2> block{reinterpret_cast<uintptr_t>(text.data()), text.size()};
    register uint32_t r0 asm("r0") = 0x15;  // semihosting: SYS_GET_CMDLINE
    register void* r1 asm("r1") = block.data();
    asm volatile("bkpt 0xab" : "+r"(r0) : "r"(r1) : "memory");
    return std::strstr(text.data(), word) != nullptr;
}

void Wrecker::step(WreckerPorts&) {
    volatile uint32_t start = 0;
    if (was_told("null")) read_null(nullptr);
    if (was_told("code")) write_code();
    if (was_told("data")) run_data();
    if (was_told("stack")) recurse(&start);
    if (was_told("divide")) divide();
    if (was_told("endless")) never_end();
    if (was_told("assertion")) require(false, "the wrecker was told to fail");
}

}  // namespace stator::apps::wrecker
