// Pins (RM0090, 8.4). A pin is a constant of the board; each call is one or a few stores, from any
// context, as long as no two contexts configure pins of one port at once (boards do it at start).
#pragma once

#include <cstdint>

#include "stator/registers.hpp"
#include "stm32f4/clock_tree.hpp"

namespace stator::stm32f4 {

class Pin {
  public:
    // `port`: 'A' to 'I'; `number`: 0 to 15.
    constexpr Pin(char port, uint32_t number)
        : base_(0x40020000U + 0x400U * index(port)), port_(index(port)), number_(number) {}

    void make_input() const { configure(kInput, 0); }
    void make_pulled_up_input() const { configure(kInput, kPullUp); }
    // Drives `is_high` from the first instant on.
    void make_output(bool is_high) const {
        switch_on();
        write(is_high);
        configure(kOutput, 0);
    }
    // Pulls low or lets go: high is whatever voltage the other end has.
    void make_open_drain(bool is_high) const {
        switch_on();
        write(is_high);
        Register(base_ + 0x04).set(1U << number_);  // GPIOx_OTYPER
        configure(kOutput, 0);
    }
    // 8.3.2; which number means which peripheral is in the data sheet.
    void make_alternate(uint32_t function) const {
        switch_on();
        const Register functions(base_ + 0x20 + 4 * (number_ / 8));
        const uint32_t shift = 4 * (number_ % 8);
        functions.write((functions.read() & ~(0xFU << shift)) | function << shift);
        configure(kAlternate, kPullUp);
    }

    void write(bool is_high) const {
        Register(base_ + 0x18).write(1U << (is_high ? number_ : number_ + 16));  // GPIOx_BSRR
    }
    bool is_high() const { return (Register(base_ + 0x10).read() >> number_ & 1U) != 0; }

  private:
    static constexpr uint32_t kInput = 0;
    static constexpr uint32_t kOutput = 1;
    static constexpr uint32_t kAlternate = 2;
    static constexpr uint32_t kPullUp = 1;
    static constexpr uint32_t kLowSpeed = 0;
    static constexpr uint32_t kMediumSpeed = 1;

    static constexpr uint32_t index(char port) { return static_cast<uint32_t>(port - 'A'); }

    void switch_on() const { rcc::kAhb1Enable.set(1U << port_); }
    void set_field(uint32_t offset, uint32_t value) const {
        const Register reg(base_ + offset);
        reg.write((reg.read() & ~(3U << 2 * number_)) | value << 2 * number_);
    }
    // PC13 to PC15 hang on the switch of the backup supply: 2 MHz and 3 mA at most (5.1.2).
    uint32_t speed() const {
        const bool is_weak = port_ == index('C') && number_ >= 13;
        return is_weak ? kLowSpeed : kMediumSpeed;
    }
    void configure(uint32_t mode, uint32_t pull) const {
        switch_on();
        set_field(0x0C, pull);     // GPIOx_PUPDR
        set_field(0x08, speed());  // GPIOx_OSPEEDR
        set_field(0x00, mode);     // GPIOx_MODER, last: the pin drives from here on
    }

    uint32_t base_;
    uint32_t port_;
    uint32_t number_;
};

}  // namespace stator::stm32f4
