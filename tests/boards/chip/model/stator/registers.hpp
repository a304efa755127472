// Stands in for the chip's registers in tests: each access goes to the model of the chip, and takes
// time, as the code around it does.
#pragma once

#include <cstdint>

#include "chip/chip.hpp"

namespace stator {

// The chip that drivers under test run on. One at a time.
inline chip::Chip* current_chip = nullptr;

class Register {
  public:
    explicit constexpr Register(uint32_t address) : address_(address) {}
    uint32_t read() const {
        pass();
        return current_chip->read(address_, 4);
    }
    void write(uint32_t value) const {
        pass();
        current_chip->write(address_, value, 4);
    }
    void set(uint32_t bits) const { write(read() | bits); }
    void clear(uint32_t bits) const { write(read() & ~bits); }

  private:
    static constexpr uint64_t kAccess_ns = 24;  // 4 cycles at 168 MHz
    static void pass() { current_chip->move(current_chip->now_ns() + kAccess_ns); }

    uint32_t address_;
};

inline void barrier() {}

}  // namespace stator
