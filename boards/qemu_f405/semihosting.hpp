// Semihosting: the emulator does what an instruction asks for, while the emulated clock stands
// still. Arm, "Semihosting for AArch32 and AArch64", 2.0. Never on hardware: there the instruction
// faults.
#pragma once

#include <cstddef>
#include <cstdint>

namespace stator::semihosting {

enum class Mode : uint32_t { kRead = 1, kWrite = 5 };  // fopen's "rb" and "wb"

// A file of the host. Each call says whether it did all that was asked; the host may block it.
class File {
  public:
    [[nodiscard]] bool open(const char* path, Mode mode);
    [[nodiscard]] bool read(void* bytes, size_t count) const;
    [[nodiscard]] bool write(const void* bytes, size_t count) const;

  private:
    int32_t handle_ = -1;
};

// On the emulator's console.
void print(const char* text);
void print(uint32_t value);
[[noreturn]] void exit(uint32_t status);

}  // namespace stator::semihosting
