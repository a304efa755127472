#include "chip/chip.hpp"

#include <algorithm>

#include "chip/backup.hpp"
#include "chip/dma.hpp"
#include "chip/exti.hpp"
#include "chip/gpio.hpp"
#include "chip/identity.hpp"
#include "chip/spi.hpp"
#include "chip/timer.hpp"
#include "chip/usart.hpp"
#include "chip/watchdog.hpp"

namespace stator::chip {

namespace {

// Offsets of RCC registers that switch clocks on.
constexpr uint32_t kAhb1 = 0x30, kApb1 = 0x40, kApb2 = 0x44;

}  // namespace

Chip::Chip(Memory& memory, uint32_t crystal_hz) : memory_(memory) {
    agenda_ = &add<Agenda>();
    auto& power = add<PowerControl>();
    auto& flash = add<FlashControl>();
    reset_and_clocks_ = &add<ResetAndClocks>(crystal_hz, power, flash);
    add<Watchdog>();
    add<Backup>(power);
    add<BackupRam>(power);
    add<DeviceId>();
    add<Debug>();
    auto& config = add<SystemConfiguration>();
    auto& exti = add<Exti>(config);
    for (char port = 'A'; port <= 'I'; ++port) add<Gpio>(port, exti);
    dma_[0] = &add<Dma>(1);
    dma_[1] = &add<Dma>(2);

    using Bus = Timer::Bus;
    timers_[1] = &add<Timer>("TIM1", 0x40010000, Gate{kApb2, 0}, Bus::kApb2, 25U, 16U, 4U);
    timers_[2] = &add<Timer>("TIM2", 0x40000000, Gate{kApb1, 0}, Bus::kApb1, 28U, 32U, 4U);
    timers_[3] = &add<Timer>("TIM3", 0x40000400, Gate{kApb1, 1}, Bus::kApb1, 29U, 16U, 4U);
    timers_[4] = &add<Timer>("TIM4", 0x40000800, Gate{kApb1, 2}, Bus::kApb1, 30U, 16U, 4U);
    timers_[5] = &add<Timer>("TIM5", 0x40000C00, Gate{kApb1, 3}, Bus::kApb1, 50U, 32U, 4U);

    add_usart("USART1", 0x40011000, {kApb2, 4}, 37);
    add_usart("USART2", 0x40004400, {kApb1, 17}, 38);
    add_usart("USART3", 0x40004800, {kApb1, 18}, 39);
    add_usart("UART4", 0x40004C00, {kApb1, 19}, 52);
    add_usart("USART6", 0x40011400, {kApb2, 5}, 71);
    add_usart("UART7", 0x40007800, {kApb1, 30}, 82);
    add_usart("UART8", 0x40007C00, {kApb1, 31}, 83);

    spis_.push_back(&add<Spi>("SPI1", 0x40013000, Gate{kApb2, 12}, 35U));
    spis_.push_back(&add<Spi>("SPI2", 0x40003800, Gate{kApb1, 14}, 36U));
    spis_.push_back(&add<Spi>("SPI4", 0x40013400, Gate{kApb2, 13}, 84U));
    for (Dma* dma : dma_) {
        for (Spi* spi : spis_) dma->connect(*spi);
        for (Usart* usart : usarts_) dma->connect(*usart);
    }
    reset_and_clocks_->note_reset(ResetCause::kPowerOn);
}

void Chip::add_usart(const char* name, uint32_t base, Gate gate, unsigned line) {
    usarts_.push_back(&add<Usart>(name, base, gate, line));
}

Usart& Chip::usart(std::string_view name) {
    const auto found = std::ranges::find_if(usarts_, [&](Usart* u) { return u->name() == name; });
    return **found;
}

Spi& Chip::spi(std::string_view name) {
    const auto found = std::ranges::find_if(spis_, [&](Spi* spi) { return spi->name() == name; });
    return **found;
}

Block& Chip::block_at(uint32_t address) {
    for (const auto& block : blocks_) {
        if (address - block->base() < block->size()) return *block;
    }
    if (address - 0x08000000U < 0x200000U)
        throw Violation("the flash is written, but not unlocked");
    throw Violation(hex(address) + ": there is no peripheral, or it is not modelled");
}

uint32_t Chip::read(uint32_t address, unsigned bytes) {
    Block& block = block_at(address);
    if (!reset_and_clocks_->is_on(block.gate())) {
        throw Violation(block.name() + ": read while its clock is off");
    }
    const uint32_t value = block.read(address - block.base(), bytes);
    constant_ = {};
    if (block.is_constant() && bytes == 4) {
        constant_ = {.address = address, .first = value, .divider = 1, .from_ns = now_ns_};
    }
    return value;
}

void Chip::write(uint32_t address, uint32_t value, unsigned bytes) {
    constant_ = {};
    Block& block = block_at(address);
    if (!reset_and_clocks_->is_on(block.gate())) {
        throw Violation(block.name() + ": written while its clock is off");
    }
    block.write(address - block.base(), value, bytes);
}

void Chip::move(uint64_t now_ns) {
    for (;;) {
        Block* next = nullptr;
        uint64_t due_ns = kNever;
        for (const auto& block : blocks_) {
            const uint64_t due = block->due_ns();
            if (due < due_ns) {
                due_ns = due;
                next = block.get();
            }
        }
        if (due_ns > now_ns) break;
        constant_ = {};
        now_ns_ = std::max(now_ns_, due_ns);
        next->run();
    }
    now_ns_ = std::max(now_ns_, now_ns);
}

uint64_t Chip::visible_ns() const {
    uint64_t first = kNever;
    for (const auto& block : blocks_) first = std::min(first, block->visible_ns());
    return first;
}

wire::Known Chip::known(uint64_t until_ns) const {
    wire::Known known{};
    if (read_timer_ != nullptr && reset_and_clocks_->is_on(read_timer_->gate())) {
        known[0] = read_timer_->counter();
    }
    known[1] = constant_;
    known[1].until_ns = until_ns;
    return known;
}

void Chip::reset() {
    levels_ = {};
    for (const auto& block : blocks_) block->reset();
}

bool Chip::take_reset_request() {
    return std::exchange(is_reset_requested_, false);
}

void Chip::set_line(unsigned line, bool is_high) {
    const uint32_t bit = 1U << line % 32;
    uint32_t& word = levels_[line / 32];
    word = is_high ? word | bit : word & ~bit;
}

void Chip::request_reset(ResetCause cause) {
    reset_and_clocks_->note_reset(cause);
    is_reset_requested_ = true;
}

void Chip::clocks_change() {
    for (const auto& block : blocks_) block->settle();
}

// What moves an item asks for the next one: no further inside.
void Chip::serve_dma() {
    if (serves_dma_) return;
    serves_dma_ = true;
    while (dma_[0]->move_item() || dma_[1]->move_item()) {
    }
    serves_dma_ = false;
}

}  // namespace stator::chip
