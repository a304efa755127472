// Semihosting: the emulator does what an instruction asks for, while the emulated clock stands
// still. Arm, "Semihosting for AArch32 and AArch64", 2.0. Never on hardware: there the instruction
// faults.
#pragma once

#include <cstddef>
#include <cstdint>

namespace stator::semihosting {

// fopen's "rb", "r+b" and "wb".
enum class Mode : uint32_t { kRead = 1, kChange = 3, kWrite = 5 };

// A file of the host. Each call says whether it did all that was asked; the host may block it.
class File {
  public:
    bool is_open() const { return handle_ != -1; }
    [[nodiscard]] bool open(const char* path, Mode mode);
    [[nodiscard]] bool seek(uint32_t place) const;  // from the beginning
    [[nodiscard]] bool read(void* bytes, size_t count) const;
    [[nodiscard]] bool write(const void* bytes, size_t count) const;

  private:
    int32_t handle_ = -1;
};

// True if the word stands on the command line that the host gives the firmware, between blanks: the
// line begins with the image's path.
bool was_told(const char* word);

// On the emulator's console.
void print(const char* text);
void print(uint32_t value);
void print_byte(uint8_t value);  // two hexadecimal digits
[[noreturn]] void exit(uint32_t status);

}  // namespace stator::semihosting
