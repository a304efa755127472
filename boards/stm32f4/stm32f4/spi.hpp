// A serial bus as its master, whose bytes DMA moves (RM0090, 28.5), and one part on it.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>

#include "stator/registers.hpp"
#include "stm32f4/dma.hpp"
#include "stm32f4/gpio.hpp"

namespace stator::stm32f4 {

// `Sent` and `Received` are DmaBuffers. All calls from one level.
template <class Sent, class Received>
class Spi {
  public:
    constexpr Spi(uint32_t base, DmaStream send, DmaStream receive)
        : base_(base), send_(send), receive_(receive) {}

    // The clock of the bus is on. Mode 3: the clock rests high, the second edge samples.
    void start() const {
        send_.switch_on();
        receive_.switch_on();
        at(kControl1).write(kSettings);
        at(kControl2).write(kReceiveDma | kSendDma);
    }
    // `divider`: the bus's clock by 2^(divider + 1). The end of the transfer raises the vector of
    // the receiving stream. False: the DMA did not start.
    [[nodiscard]] bool transfer(std::span<const uint8_t> bytes, uint32_t divider) const {
        std::copy(bytes.begin(), bytes.end(), Sent::bytes);
        at(kControl1).write(kSettings | divider << 3);
        return receive_.receive_once(base_ + kData, Received::bytes, bytes.size()) &&
               send_.send(base_ + kData, Sent::bytes, bytes.size());
    }
    // At the end: what came in.
    void take(std::span<uint8_t> bytes) const {
        receive_.acknowledge();
        std::copy_n(Received::bytes, bytes.size(), bytes.begin());
    }

  private:
    static constexpr uint32_t kControl1 = 0x00;  // SPI_CR1
    static constexpr uint32_t kControl2 = 0x04;  // SPI_CR2
    static constexpr uint32_t kData = 0x0C;      // SPI_DR
    static constexpr uint32_t kMode3 = 3U << 0;
    static constexpr uint32_t kMaster = 1U << 2;
    static constexpr uint32_t kEnable = 1U << 6;
    static constexpr uint32_t kSoftwareSelect = 3U << 8;
    static constexpr uint32_t kSettings = kMode3 | kMaster | kEnable | kSoftwareSelect;
    static constexpr uint32_t kReceiveDma = 1U << 0;
    static constexpr uint32_t kSendDma = 1U << 1;

    Register at(uint32_t offset) const { return Register(base_ + offset); }

    uint32_t base_;
    DmaStream send_;
    DmaStream receive_;
};

// A part that says by a line that it has a sample: each transfer begins at the line, so that its
// time is the sample's. `bus`: an `Spi`, a constant, so that its addresses are; `Device` is the
// driver's (drivers/imu/mpu6000). All calls from one level, above the driver's.
template <const auto& bus, class Device>
class PartOnSpi {
  public:
    struct Dividers {
        uint32_t slow, fast;
    };
    constexpr PartOnSpi(Pin select, Dividers dividers, Device& device)
        : select_(select), dividers_(dividers), device_(device) {}

    // The line. A driver that is late loses the sample, and nothing else.
    void ready(uint64_t now_us) {
        if (!moves_ && device_.state.load() == Device::kArmed) begin(now_us, true);
    }
    // Once a millisecond. True: the driver is to be activated, as nothing moves.
    [[nodiscard]] bool tick(uint64_t now_us) {
        if (moves_ || now_us - last_us_ < (has_line_ ? kSilence_us : kTick_us)) return false;
        if (device_.state.load() != Device::kArmed) return true;
        begin(now_us, false);
        return false;
    }
    // The end of a transfer. True: the driver is to be activated.
    [[nodiscard]] bool finish() {
        select_.write(true);
        Transfer& done = is_second_ ? device_.second : device_.first;
        bus.take(std::span(done.bytes).first(done.count));
        if (!is_second_ && device_.second.count != 0) {
            is_second_ = true;
            move(device_.second);
            return false;
        }
        moves_ = false;
        device_.state.store(Device::kIdle);
        return true;
    }

  private:
    using Transfer = decltype(Device::first);
    static constexpr uint64_t kSilence_us = 2'000;  // then ticks stand in for lines
    static constexpr uint64_t kTick_us = 900;

    void begin(uint64_t now_us, bool is_ready) {
        device_.time_us = now_us;
        device_.is_ready = is_ready;
        last_us_ = now_us;
        has_line_ = is_ready;
        moves_ = true;
        is_second_ = false;
        move(device_.first);
    }
    // Without DMA nothing comes in, which the driver sees.
    void move(Transfer& transfer) {
        select_.write(false);
        const uint32_t divider = transfer.is_fast ? dividers_.fast : dividers_.slow;
        if (bus.transfer(std::span(transfer.bytes).first(transfer.count), divider)) return;
        select_.write(true);
        moves_ = false;
        device_.state.store(Device::kIdle);
    }

    Pin select_;
    Dividers dividers_;
    Device& device_;
    uint64_t last_us_ = 0;  // when the last one began
    bool has_line_ = false;
    bool moves_ = false;
    bool is_second_ = false;
};

}  // namespace stator::stm32f4
