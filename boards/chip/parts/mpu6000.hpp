// The MPU6000 as a part on the bus: InvenSense RM-MPU-6000A (registers) and PS-MPU-6000A (times).
#pragma once

#include <array>
#include <cstdint>
#include <functional>

#include "chip/chip.hpp"
#include "chip/spi.hpp"

namespace stator::chip {

class Mpu6000 : public SpiPart {
  public:
    // What acts on the part, along its own axes.
    struct Motion {
        std::array<double, 3> rate{};   // rad/s
        std::array<double, 3> force{};  // m/s^2, specific
        double temperature_c = 25.0;
    };
    using Source = std::function<Motion(uint64_t now_ns)>;
    struct Faults {
        bool is_silent = false;  // answers nothing, says nothing
        bool is_stuck = false;   // always the same sample
        bool has_no_line = false;
        uint8_t identity = 0x68;
    };

    // `line`: the pin of the chip that its interrupt output drives.
    Mpu6000(Chip& chip, unsigned line, Source source);

    Faults faults;
    // A short loss of its supply: all registers have the values of a reset.
    void brown_out();
    uint64_t samples() const { return samples_; }
    // Samples that were read to their end, each once.
    uint64_t bursts() const { return bursts_; }
    // Of those from the first read one to the last.
    uint64_t missed() const {
        return bursts_ == 0 ? 0 : read_sample_ + 1 - first_sample_ - bursts_;
    }

    void select(bool is_selected) override;
    uint8_t exchange(uint8_t sent, uint32_t clock_hz, unsigned mode) override;

  private:
    void reset();
    void start();
    void sample(unsigned generation);
    void write(uint8_t reg, uint8_t value);
    uint8_t read(uint8_t reg) const;
    void set_line(bool is_active);
    uint64_t period_ns() const;

    static constexpr unsigned kRegisters = 128;
    Chip& chip_;
    unsigned line_;
    Source source_;
    std::array<uint8_t, kRegisters> registers_{};
    std::array<uint8_t, 14> shown_{};  // what a burst reads: one sample
    uint64_t ready_ns_ = 0;            // registers answer from here on
    unsigned generation_ = 0;          // of the sampling that runs
    uint64_t samples_ = 0;
    uint64_t bursts_ = 0;
    uint64_t first_sample_ = 0;
    uint64_t read_sample_ = 0;  // the number of the one that was read last
    bool has_address_ = false;
    bool is_read_ = false;
    uint8_t address_ = 0;
};

}  // namespace stator::chip
