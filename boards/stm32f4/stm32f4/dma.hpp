// One stream of the DMA controllers (RM0090, 10.5), and the memory it may use.
#pragma once

#include <cstddef>
#include <cstdint>

#include "stator/registers.hpp"
#include "stm32f4/clock_tree.hpp"
#include "stm32f4/wait.hpp"

namespace stator::stm32f4 {

// Bytes that DMA reads or writes. DMA does not reach the core-coupled memory, where the stack is,
// so such a buffer has no objects: it is static, one for each `Owner`, and the build checks in the
// image that each one lies where DMA reaches.
template <class Owner, size_t kSize>
struct DmaBuffer {
    DmaBuffer() = delete;
    static constexpr size_t size() { return kSize; }
    alignas(4) inline static uint8_t bytes[kSize];
};

class DmaStream {
  public:
    // `controller`: 1 or 2; `stream` and `channel`: 0 to 7 (tables 42 and 43).
    constexpr DmaStream(uint32_t controller, uint32_t stream, uint32_t channel)
        : controller_(controller), stream_(stream), channel_(channel) {}

    // The controller's clock, once before all else: its register is shared, so a change by a task
    // that interrupts this one would be lost.
    void switch_on() const { rcc::kAhb1Enable.set(1U << (20 + controller_)); }
    // Between a peripheral's data register and `bytes`. False: the stream's last transfer did not
    // stop within its bound, and nothing was started.
    [[nodiscard]] bool send(uint32_t data_register, const uint8_t* bytes, size_t count) const {
        return start(data_register, bytes, count, kToPeripheral);
    }
    // The same; the end raises the stream's vector until it is acknowledged.
    [[nodiscard]] bool send_once(uint32_t data_register, const uint8_t* bytes, size_t count) const {
        return start(data_register, bytes, count, kToPeripheral | kEndInterrupt);
    }
    // For ever, around and around.
    [[nodiscard]] bool receive(uint32_t data_register, uint8_t* bytes, size_t count) const {
        return start(data_register, bytes, count, kCircular);
    }
    // Once; the end raises the stream's vector until it is acknowledged.
    [[nodiscard]] bool receive_once(uint32_t data_register, uint8_t* bytes, size_t count) const {
        return start(data_register, bytes, count, kEndInterrupt);
    }
    // What is read after this call is not read before the end.
    void acknowledge() const {
        clear_flags();
        barrier();
    }
    // Items still to come in this round. The buffer is plain memory, which a volatile access does
    // not order: the barrier makes what is read after this call what has come in by now.
    size_t left() const {
        const size_t items = at(0x04).read();
        barrier();
        return items;
    }
    // What is written after this call is not written before the last transfer's end.
    bool is_busy() const {
        const bool busy = (at(0x00).read() & kEnable) != 0;
        barrier();
        return busy;
    }

  private:
    static constexpr uint32_t kEnable = 1U << 0;
    static constexpr uint32_t kEndInterrupt = 1U << 4;
    static constexpr uint32_t kToPeripheral = 1U << 6;
    static constexpr uint32_t kCircular = 1U << 8;
    static constexpr uint32_t kIncrement = 1U << 10;
    static constexpr uint32_t kAllFlags = 0x3D;
    // A stream that is switched off ends the item it moves (10.3.17): some ten cycles of the bus.
    static constexpr uint32_t kMaxReads = 1'000;

    constexpr uint32_t base() const { return 0x40026000U + 0x400U * (controller_ - 1); }
    Register at(uint32_t offset) const { return Register(base() + 0x10 + 0x18 * stream_ + offset); }

    bool start(uint32_t data_register, const uint8_t* bytes, size_t count,
               uint32_t direction) const {
        const Register control = at(0x00);  // DMA_SxCR; 10.3.17 gives the order
        control.write(0);
        if (!wait_until(control, kEnable, 0, kMaxReads)) return false;
        clear_flags();
        at(0x08).write(data_register);                                              // DMA_SxPAR
        at(0x0C).write(static_cast<uint32_t>(reinterpret_cast<uintptr_t>(bytes)));  // DMA_SxM0AR
        at(0x04).write(static_cast<uint32_t>(count));                               // DMA_SxNDTR
        const uint32_t settings = channel_ << 25 | kIncrement | direction;
        control.write(settings);
        barrier();  // the bytes are in memory before the stream fetches them
        control.write(settings | kEnable);
        return true;
    }
    // DMA_LIFCR and DMA_HIFCR: four streams each, at bits 0, 6, 16 and 22.
    void clear_flags() const {
        const uint32_t shift = (stream_ % 4) / 2 * 16 + stream_ % 2 * 6;
        Register(base() + 0x08 + 4 * (stream_ / 4)).write(kAllFlags << shift);
    }

    uint32_t controller_;
    uint32_t stream_;
    uint32_t channel_;
};

}  // namespace stator::stm32f4
