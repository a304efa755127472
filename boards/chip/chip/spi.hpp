// A serial peripheral interface as the master of a bus, 8 bits at a time: RM0090, chapter 28.
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "chip/block.hpp"
#include "chip/dma.hpp"

namespace stator::chip {

// What is on the bus.
class SpiPart {
  public:
    SpiPart() = default;
    virtual ~SpiPart() = default;
    SpiPart(const SpiPart&) = delete;
    SpiPart& operator=(const SpiPart&) = delete;

    virtual void select(bool is_selected) = 0;
    // A byte each way. `clock_hz`, `mode`: of the master (clock polarity and phase: 0 to 3).
    virtual uint8_t exchange(uint8_t sent, uint32_t clock_hz, unsigned mode) = 0;
};

class Spi : public Block, public DmaClient {
  public:
    Spi(Chip& chip, const char* name, uint32_t base, Gate gate, unsigned line);
    // Selected by a low level of the pin.
    void attach(SpiPart& part, unsigned select_pin);

    void reset() override;
    uint64_t due_ns() const override { return end_ns_; }
    uint64_t visible_ns() const override;
    void run() override;

    std::span<const Request> requests() const override;
    bool asks(bool is_to_peripheral) const override;
    uint32_t data_address() const override { return base() + 0x0C; }

  private:
    uint32_t on_read(uint32_t offset) override;
    void on_write(uint32_t offset, uint32_t value) override;
    void control(uint32_t value);
    void load();
    void update();
    uint8_t exchange(uint8_t sent) const;
    uint32_t clock_hz() const;
    uint64_t byte_ns() const;

    struct Place {
        SpiPart* part;
        unsigned select_pin;
    };
    unsigned line_;
    std::vector<Place> places_;
    std::optional<uint8_t> waiting_;  // in the transmit buffer
    std::optional<uint8_t> shifting_;
    uint64_t end_ns_ = kNever;
    bool overrun_was_read_ = false;  // the data register, after the overrun
};

}  // namespace stator::chip
