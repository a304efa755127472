// Semihosting calls.
#include "semihosting.hpp"

#include <array>
#include <cstring>

namespace stator::semihosting {

namespace {

// Numbers of the operations, section 7 of the specification.
constexpr uint32_t kOpen = 0x01;
constexpr uint32_t kWrite0 = 0x04;
constexpr uint32_t kWrite = 0x05;
constexpr uint32_t kRead = 0x06;
constexpr uint32_t kSeek = 0x0A;
constexpr uint32_t kCommandLine = 0x15;
constexpr uint32_t kExitExtended = 0x20;
constexpr uint32_t kApplicationExit = 0x20026;

int32_t call(uint32_t operation, const void* block) {
    register uint32_t r0 asm("r0") = operation;
    register const void* r1 asm("r1") = block;
    asm volatile("bkpt 0xab" : "+r"(r0) : "r"(r1) : "memory");
    return static_cast<int32_t>(r0);
}

uint32_t word(const void* pointer) {
    return reinterpret_cast<uint32_t>(pointer);
}

// Both answer how many bytes are left undone.
bool transfer(uint32_t operation, int32_t handle, const void* bytes, size_t count) {
    const std::array<uint32_t, 3> block{static_cast<uint32_t>(handle), word(bytes), count};
    return call(operation, block.data()) == 0;
}

}  // namespace

bool File::open(const char* path, Mode mode) {
    const std::array<uint32_t, 3> block{word(path), static_cast<uint32_t>(mode), std::strlen(path)};
    handle_ = call(kOpen, block.data());
    return handle_ != -1;
}

bool File::seek(uint32_t place) const {
    const std::array<uint32_t, 2> block{static_cast<uint32_t>(handle_), place};
    return call(kSeek, block.data()) == 0;
}

bool File::read(void* bytes, size_t count) const {
    return transfer(kRead, handle_, bytes, count);
}

bool File::write(const void* bytes, size_t count) const {
    return transfer(kWrite, handle_, bytes, count);
}

bool was_told(const char* word_to_find) {
    std::array<char, 256> text{};
    std::array<uint32_t, 2> block{word(text.data()), text.size()};
    if (call(kCommandLine, block.data()) != 0) return false;
    const size_t length = std::strlen(word_to_find);
    const char* found = std::strstr(text.data(), word_to_find);
    for (; found != nullptr; found = std::strstr(found + 1, word_to_find)) {
        const bool begins = found == text.data() || found[-1] == ' ';
        if (begins && (found[length] == ' ' || found[length] == '\0')) return true;
    }
    return false;
}

void print(const char* text) {
    call(kWrite0, text);
}

void print(uint32_t value) {
    std::array<char, 11> text{'0', 'x'};
    for (unsigned digit = 0; digit < 8; ++digit) {
        text[2 + digit] = "0123456789abcdef"[(value >> (28 - 4 * digit)) & 0xFU];
    }
    print(text.data());
}

void print_byte(uint8_t value) {
    constexpr char kDigits[] = "0123456789abcdef";
    const std::array<char, 3> text{kDigits[value >> 4], kDigits[value & 0xFU]};
    print(text.data());
}

void exit(uint32_t status) {
    const std::array<uint32_t, 2> block{kApplicationExit, status};
    while (true) call(kExitExtended, block.data());
}

}  // namespace stator::semihosting
