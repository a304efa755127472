// A chip with its RAM, for tests without an emulator.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <string>

#include "chip/chip.hpp"
#include "stator/registers.hpp"

namespace stator::chip {

class Ram : public Memory {
  public:
    static constexpr uint32_t kAt = 0x20000000;
    std::array<uint8_t, 0x1000> bytes{};

    void fetch(uint32_t address, std::span<uint8_t> to) override {
        std::copy_n(bytes.begin() + (address - kAt), to.size(), to.begin());
    }
    void store(uint32_t address, std::span<const uint8_t> from) override {
        std::ranges::copy(from, bytes.begin() + (address - kAt));
    }
};

class OnChip : public testing::Test {
  public:
    OnChip() { current_chip = &chip; }
    ~OnChip() override { current_chip = nullptr; }

    Ram ram;
    Chip chip{ram, 24'000'000};

    uint32_t read(uint32_t address) { return Register(address).read(); }
    void write(uint32_t address, uint32_t value) { Register(address).write(value); }
    void wait_us(uint64_t us) { chip.move(chip.now_ns() + us * 1000); }
    bool is_raised(unsigned line) const { return (chip.levels()[line / 32] >> line % 32 & 1) != 0; }
    // The rule that a call breaks; empty: none.
    template <class Call>
    static std::string broken_by(Call&& call) {
        try {
            call();
        } catch (const Violation& violation) {
            return violation.what();
        }
        return "";
    }
};

}  // namespace stator::chip
