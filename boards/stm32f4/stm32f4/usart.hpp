// A USART whose bytes DMA moves (RM0090, 30.6): sending costs no interrupt, and what comes in waits
// in a ring until it is read.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>

#include "stator/registers.hpp"
#include "stm32f4/clock_tree.hpp"
#include "stm32f4/dma.hpp"

namespace stator::stm32f4 {

// `Sent` and `Received` are DmaBuffers. One task uses an object; not from two levels.
template <class Sent, class Received>
class Usart {
  public:
    constexpr Usart(uint32_t base, DmaStream send, DmaStream receive)
        : base_(base), send_(send), receive_(receive) {}

    // 8 data bits, no parity, 1 stop bit. `bus_hz`: the clock of its bus, which is on already.
    // False: the DMA did not start.
    [[nodiscard]] bool start(uint32_t bus_hz, uint32_t baud) {
        send_.switch_on();
        receive_.switch_on();
        at(kControl1).write(0);
        at(kBaud).write((bus_hz + baud / 2) / baud);
        at(kControl3).write(kDmaReceive | kDmaSend);
        at(kControl1).write(kEnable | kReceive | kSend);
        return receive_.receive(base_ + kData, Received::bytes, Received::size());
    }

    // From here on a pause of the other end, as long as a byte, raises the vector.
    void hear_pauses() const { at(kControl1).set(kPause); }
    // Whether there was one. Reading both registers clears it (30.6.1).
    [[nodiscard]] bool take_pause() const {
        const bool is_pause = (at(kStatus).read() & kPause) != 0;
        if (is_pause) static_cast<void>(at(kData).read());
        return is_pause;
    }

    // Copies what fits into the buffer of a free sender, and starts to send it. Returns how many
    // bytes it took: 0 while the last ones are still going out.
    [[nodiscard]] size_t write(std::span<const uint8_t> bytes) const {
        if (send_.is_busy()) return 0;
        const size_t count = std::min(bytes.size(), Sent::size());
        std::copy_n(bytes.begin(), count, Sent::bytes);
        if (count == 0 || !send_.send(base_ + kData, Sent::bytes, count)) return 0;
        return count;
    }

    // Takes what came in since the last call, as far as there is room. A ring that ran over loses a
    // whole round of bytes; the protocol above has a checksum.
    size_t read(std::span<uint8_t> bytes) {
        const size_t filled = (Received::size() - receive_.left()) % Received::size();
        size_t count = 0;
        while (taken_ != filled && count < bytes.size()) {
            bytes[count++] = Received::bytes[taken_];
            taken_ = (taken_ + 1) % Received::size();
        }
        return count;
    }

  private:
    static constexpr uint32_t kStatus = 0x00;    // USART_SR
    static constexpr uint32_t kPause = 1U << 4;  // IDLE, and IDLEIE of USART_CR1
    static constexpr uint32_t kData = 0x04;      // USART_DR
    static constexpr uint32_t kBaud = 0x08;      // USART_BRR: the divider in sixteenths, 30.3.4
    static constexpr uint32_t kControl1 = 0x0C;  // USART_CR1
    static constexpr uint32_t kControl3 = 0x14;  // USART_CR3
    static constexpr uint32_t kEnable = 1U << 13;
    static constexpr uint32_t kSend = 1U << 3;
    static constexpr uint32_t kReceive = 1U << 2;
    static constexpr uint32_t kDmaSend = 1U << 7;
    static constexpr uint32_t kDmaReceive = 1U << 6;

    Register at(uint32_t offset) const { return Register(base_ + offset); }

    uint32_t base_;
    DmaStream send_;
    DmaStream receive_;
    size_t taken_ = 0;
};

}  // namespace stator::stm32f4
