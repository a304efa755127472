// A USART of STM32F4 chips, by its registers (RM0090, chapter 30), with a ring of bytes each way.
//
// Each byte is an interrupt, of hardware priority 0: it waits for no task, so that none is lost
// while one runs, and it touches nothing but the rings. The same code runs on the chip and in the
// emulator, which has no DMA: docs/decisions has the cost.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <span>

#include "stator/one_core_topic.hpp"

namespace stator::drivers::serial::usart {

// RM0090, 30.6: offsets and bits.
inline constexpr uint32_t kStatus = 0x00;  // USART_SR
inline constexpr uint32_t kFramingError = 1U << 1;
inline constexpr uint32_t kNoise = 1U << 2;
inline constexpr uint32_t kOverrun = 1U << 3;
inline constexpr uint32_t kHasReceived = 1U << 5;  // RXNE
inline constexpr uint32_t kHasRoom = 1U << 7;      // TXE
inline constexpr uint32_t kData = 0x04;            // USART_DR
inline constexpr uint32_t kRate = 0x08;            // USART_BRR: the divider in sixteenths, 30.3.4
inline constexpr uint32_t kControl1 = 0x0C;        // USART_CR1
inline constexpr uint32_t kReceive = 1U << 2;
inline constexpr uint32_t kSend = 1U << 3;
inline constexpr uint32_t kReceivedInterrupt = 1U << 5;
inline constexpr uint32_t kRoomInterrupt = 1U << 7;
inline constexpr uint32_t kEnable = 1U << 13;
inline constexpr uint32_t kControl2 = 0x10;  // USART_CR2
inline constexpr uint32_t kControl3 = 0x14;  // USART_CR3

// The chip's own registers.
struct Memory {
    uintptr_t base = 0;
    uint32_t read(uint32_t offset) const { return *at(offset); }
    void write(uint32_t offset, uint32_t value) const { *at(offset) = value; }

  private:
    volatile uint32_t* at(uint32_t offset) const {
        return reinterpret_cast<volatile uint32_t*>(base + offset);
    }
};

// Bytes from one level to another, of which each uses only its own functions.
template <uint32_t kSize>
class Ring {
    static_assert(std::has_single_bit(kSize), "places are counted modulo 2^32");

  public:
    // The one that puts: bytes behind those that are there, which count from `commit` on. False:
    // they do not fit.
    bool add(std::span<const uint8_t> bytes) {
        if (bytes.size() > kSize - (added_ - begin_.load())) return false;
        for (const uint8_t byte : bytes) bytes_[added_++ % kSize] = byte;
        return true;
    }
    void commit() { end_.store(added_); }
    void drop() { added_ = end_.load(); }
    // The one that takes. False: there is none.
    bool take(uint8_t& byte) {
        const uint32_t begin = begin_.load();
        if (begin == end_.load()) return false;
        byte = bytes_[begin % kSize];
        begin_.store(begin + 1);
        return true;
    }

  private:
    std::array<uint8_t, kSize> bytes_{};
    Shared<uint32_t> begin_;  // modulo 2^32, as `end_`
    Shared<uint32_t> end_;
    uint32_t added_ = 0;
};

// `Registers` has read(offset) and write(offset, value). `interrupt` is of the vector, all else of
// one task.
template <class Registers>
class UsartPort {
  public:
    // 90 ms of a line at 57600 baud: what comes between two activations, and a late one.
    static constexpr uint32_t kReceivedBytes = 512;
    // 0.1 s of it, which a sender may be ahead of the line, and a datagram.
    static constexpr uint32_t kSentBytes = 1024;

    // First of all: 8 data bits, no parity, 1 stop bit, no flow control. `clock_hz`: of its bus, on
    // already.
    void start(Registers registers, uint32_t clock_hz, uint32_t baud) {
        registers_ = registers;
        registers_.write(kControl1, 0);
        registers_.write(kControl2, 0);
        registers_.write(kControl3, 0);
        registers_.write(kRate, (clock_hz + baud / 2) / baud);
        registers_.write(kControl1, kRuns);
    }

    // What is added goes out once it is committed. False: it does not fit.
    [[nodiscard]] bool add(std::span<const uint8_t> bytes) { return out_.add(bytes); }
    void drop() { out_.drop(); }
    // The interrupt finds the bytes, or it comes once in vain.
    void commit() {
        out_.commit();
        registers_.write(kControl1, kRuns | kRoomInterrupt);
    }

    // How many bytes came, as far as there is room for them.
    uint32_t take(std::span<uint8_t> bytes) {
        uint32_t count = 0;
        while (count < bytes.size() && in_.take(bytes[count])) ++count;
        return count;
    }
    // Bytes that came and found no room, or came damaged; at least, as the chip counts none that it
    // could not hold (30.3.3).
    uint32_t lost() const { return lost_.load(); }

    void interrupt() {
        // Reading the data register after this one clears the errors, too (30.6.1).
        const uint32_t status = registers_.read(kStatus);
        if ((status & (kHasReceived | kOverrun)) != 0) receive(status);
        if ((status & kHasRoom) != 0) send();
    }

  private:
    static constexpr uint32_t kRuns = kEnable | kReceive | kSend | kReceivedInterrupt;

    void receive(uint32_t status) {
        const auto byte = static_cast<uint8_t>(registers_.read(kData));
        uint32_t lost = (status & kOverrun) != 0 ? 1 : 0;
        if ((status & kHasReceived) != 0) {
            const bool is_whole = (status & (kFramingError | kNoise)) == 0;
            if (is_whole && in_.add({&byte, 1})) {
                in_.commit();
            } else {
                ++lost;
            }
        }
        if (lost != 0) lost_.store(lost_.load() + lost);
    }
    void send() {
        uint8_t byte = 0;
        if (out_.take(byte)) {
            registers_.write(kData, byte);
        } else {
            registers_.write(kControl1, kRuns);
        }
    }

    Registers registers_{};
    Ring<kReceivedBytes> in_;
    Ring<kSentBytes> out_;
    Shared<uint32_t> lost_;
};

}  // namespace stator::drivers::serial::usart
