// The serial port of this board's link: USART1, whose other end the emulator gives to the host. It
// has no baud rate here. Registers: RM0090, section 30.6.
#pragma once

#include <array>
#include <cstddef>

#include "stator/topic.hpp"

namespace stator::board {

class SerialPort {
  public:
    // At hardware priority 0; what comes waits in a ring until it is read.
    void start() const {
        kControl.write(kEnable | kReceive | kTransmit | kReceiveInterrupt);
        nvic::priority(kVector) = 0;
        nvic::set_enable(kVector / 32U).write(1U << kVector % 32U);
    }
    // In its interrupt. What finds no room is lost.
    void receive() {
        const auto byte = static_cast<uint8_t>(kData.read());
        const uint32_t end = end_.load();
        if (end - begin_.load() == ring_.size()) return;
        ring_[end % ring_.size()] = byte;
        end_.store(end + 1);
    }
    size_t read(uint8_t* bytes, size_t most) {
        size_t count = 0;
        uint32_t begin = begin_.load();
        for (; count < most && begin != end_.load(); ++count, ++begin) {
            bytes[count] = ring_[begin % ring_.size()];
        }
        begin_.store(begin);
        return count;
    }
    size_t write(const uint8_t* bytes, size_t count) const {
        size_t sent = 0;
        for (; sent < count && (kStatus.read() & kRoom) != 0; ++sent) kData.write(bytes[sent]);
        return sent;
    }

  private:
    static constexpr uint8_t kVector = 37;
    static constexpr Register kStatus{0x40011000};
    static constexpr uint32_t kRoom = 1U << 7;  // TXE
    static constexpr Register kData{0x40011004};
    static constexpr Register kControl{0x4001100C};
    static constexpr uint32_t kEnable = 1U << 13;
    static constexpr uint32_t kReceiveInterrupt = 1U << 5;
    static constexpr uint32_t kTransmit = 1U << 3;
    static constexpr uint32_t kReceive = 1U << 2;

    std::array<uint8_t, 64> ring_{};
    Shared<uint32_t> begin_;  // modulo 2^32, as `end_`
    Shared<uint32_t> end_;
};

}  // namespace stator::board
