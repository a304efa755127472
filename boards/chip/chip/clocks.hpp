// Reset and clock control, power control, and the flash's access control: RM0090, chapters 6, 5, 3.
#pragma once

#include <cstdint>

#include "chip/block.hpp"

namespace stator::chip {

struct Clocks {
    uint32_t core_hz = 16'000'000;
    uint32_t apb1_hz = 16'000'000;
    uint32_t apb2_hz = 16'000'000;
    uint32_t apb1_timer_hz = 16'000'000;
    uint32_t apb2_timer_hz = 16'000'000;
};

// Bits of RCC_CSR.
enum class ResetCause : uint32_t {
    kPin = 1U << 26,
    kPowerOn = 1U << 27 | 1U << 26 | 1U << 25,
    kSoftware = 1U << 28 | 1U << 26,
    kWatchdog = 1U << 29 | 1U << 26,
};

class PowerControl : public Block {
  public:
    explicit PowerControl(Chip& chip);
    bool is_backup_writable() const;
    // The highest core clock of the voltage scale.
    uint32_t max_core_hz() const;

  private:
    void on_write(uint32_t offset, uint32_t value) override;
};

class FlashControl : public Block {
  public:
    explicit FlashControl(Chip& chip);
    // The highest core clock for the wait states, at 2.7 to 3.6 V.
    uint32_t max_core_hz() const;

  private:
    void on_write(uint32_t offset, uint32_t value) override;
};

class ResetAndClocks : public Block {
  public:
    ResetAndClocks(Chip& chip, uint32_t crystal_hz, const PowerControl& power,
                   const FlashControl& flash);

    const Clocks& clocks() const { return clocks_; }
    bool is_on(Gate gate) const;
    bool is_pll_on() const;
    void note_reset(ResetCause cause);
    void check_flash() const;

    void reset() override;
    uint64_t due_ns() const override;
    void run() override;
    bool is_constant() const override { return true; }

  private:
    // An oscillator or PLL: on, and then ready.
    struct Source {
        uint32_t on;
        uint32_t ready;
        uint64_t start_ns;
        uint64_t ready_ns = kNever;
    };

    uint32_t on_read(uint32_t offset) override;
    void on_write(uint32_t offset, uint32_t value) override;
    void control(uint32_t value);
    void configure(uint32_t value);
    void check_pll(uint32_t value) const;
    uint32_t pll_hz() const;
    uint32_t switched_hz(uint32_t configuration) const;

    uint32_t crystal_hz_;
    const PowerControl& power_;
    const FlashControl& flash_;
    Clocks clocks_;
    Source sources_[3];
};

}  // namespace stator::chip
