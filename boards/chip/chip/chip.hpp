// The chip: its peripherals by address, its interrupt lines, and its time.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <string_view>
#include <utility>
#include <vector>

#include "chip/agenda.hpp"
#include "chip/block.hpp"
#include "chip/clocks.hpp"
#include "chip/memory.hpp"
#include "chip/pins.hpp"
#include "chip/wire.hpp"

namespace stator::chip {

class Dma;
class Spi;
class Timer;
class Usart;

class Chip {
  public:
    static constexpr unsigned kLines = 96;
    using Levels = std::array<uint32_t, kLines / 32>;

    // `crystal_hz`: of the board; 0: it has none.
    Chip(Memory& memory, uint32_t crystal_hz);

    // As the processor does; throw `Violation`.
    uint32_t read(uint32_t address, unsigned bytes);
    void write(uint32_t address, uint32_t value, unsigned bytes);
    // All that happens until then.
    void move(uint64_t now_ns);
    // Of the whole chip, as by its reset line; what the backup supply keeps stays.
    void reset();

    uint64_t now_ns() const { return now_ns_; }
    // When the processor may see something that it did not cause itself.
    uint64_t visible_ns() const;
    const Levels& levels() const { return levels_; }
    const Clocks& clocks() const { return reset_and_clocks_->clocks(); }
    // What the processor may read without asking, until something is visible: the count of the
    // timer that was read last, if it runs, and the register that was read last, if it only changes
    // when told.
    wire::Known known(uint64_t until_ns) const;
    // Whether a peripheral asks for a reset; asked once.
    bool take_reset_request();

    Pins& pins() { return pins_; }
    Memory& memory() { return memory_; }
    ResetAndClocks& reset_and_clocks() { return *reset_and_clocks_; }
    Timer& timer(unsigned number) { return *timers_.at(number); }
    Usart& usart(std::string_view name);
    Spi& spi(std::string_view name);
    // `controller`: 1 or 2.
    Dma& dma(unsigned controller) { return *dma_.at(controller - 1); }

    // Of parts on the board: a call at its time.
    void at(uint64_t time_ns, std::function<void()> call, Effect effect = Effect::kSeen) {
        agenda_->at(time_ns, effect, std::move(call));
    }

    // Of peripherals.
    void set_line(unsigned line, bool is_high);
    void request_reset(ResetCause cause);
    void clocks_change();  // before they do
    void note_read_of(const Timer& timer) { read_timer_ = &timer; }
    void serve_dma();
    template <class T, class... Arguments>
    T& add(Arguments&&... arguments) {
        auto block = std::make_unique<T>(*this, std::forward<Arguments>(arguments)...);
        T& added = *block;
        blocks_.push_back(std::move(block));
        return added;
    }

  private:
    Block& block_at(uint32_t address);
    void add_usart(const char* name, uint32_t base, Gate gate, unsigned line);

    Memory& memory_;
    Pins pins_;
    uint64_t now_ns_ = 0;
    Levels levels_{};
    bool is_reset_requested_ = false;
    std::vector<std::unique_ptr<Block>> blocks_;
    ResetAndClocks* reset_and_clocks_ = nullptr;
    Agenda* agenda_ = nullptr;
    bool serves_dma_ = false;
    std::array<Timer*, 6> timers_{};
    const Timer* read_timer_ = nullptr;
    wire::Counter constant_{};
    std::array<Dma*, 2> dma_{};
    std::vector<Usart*> usarts_;
    std::vector<Spi*> spis_;
};

}  // namespace stator::chip
