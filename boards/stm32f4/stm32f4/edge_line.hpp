// A pin whose falling edge raises a vector (RM0090, 9.2.5 and 12.3).
#pragma once

#include <cstdint>

#include "stator/registers.hpp"
#include "stm32f4/clock_tree.hpp"
#include "stm32f4/gpio.hpp"

namespace stator::stm32f4 {

class EdgeLine {
  public:
    // `port`: 'A' to 'I'; `number`: of the pin, which is the line's, too.
    constexpr EdgeLine(char port, uint32_t number)
        : pin_(port, number), port_(static_cast<uint32_t>(port - 'A')), number_(number) {}

    void start() const {
        rcc::kApb2Enable.set(kConfigurationClock);
        pin_.make_input();
        const Register ports(0x40013808U + 4 * (number_ / 4));  // SYSCFG_EXTICR1 to 4
        const uint32_t shift = 4 * (number_ % 4);
        ports.write((ports.read() & ~(0xFU << shift)) | port_ << shift);
        Register(kBase + 0x0C).set(1U << number_);  // EXTI_FTSR
        acknowledge();
        Register(kBase + 0x00).set(1U << number_);  // EXTI_IMR
    }
    void acknowledge() const { Register(kBase + 0x14).write(1U << number_); }  // EXTI_PR

  private:
    static constexpr uint32_t kBase = 0x40013C00;
    static constexpr uint32_t kConfigurationClock = 1U << 14;

    Pin pin_;
    uint32_t port_;
    uint32_t number_;
};

}  // namespace stator::stm32f4
