// A serial line, 8 data bits: RM0090, chapter 30.
#pragma once

#include <algorithm>
#include <deque>
#include <functional>
#include <optional>
#include <utility>

#include "chip/block.hpp"
#include "chip/dma.hpp"

namespace stator::chip {

class Usart : public Block, public DmaClient {
  public:
    Usart(Chip& chip, const char* name, uint32_t base, Gate gate, unsigned line);
    // Gets each byte at the end of its stop bit.
    void watch(std::function<void(uint8_t)> watcher) { watcher_ = std::move(watcher); }
    // The other end sends, at the same rate.
    void arrive(std::span<const uint8_t> bytes);
    uint64_t byte_ns() const;

    void reset() override;
    uint64_t due_ns() const override { return std::min(sent_ns_, received_ns_); }
    uint64_t visible_ns() const override;
    void run() override;

    std::span<const Request> requests() const override;
    bool asks(bool is_to_peripheral) const override;
    uint32_t data_address() const override { return base() + 0x04; }

  private:
    uint32_t on_read(uint32_t offset) override;
    void on_write(uint32_t offset, uint32_t value) override;
    void check(uint32_t offset, uint32_t value) const;
    void send(uint8_t byte);
    void load();
    void receive();
    void update();

    unsigned line_;
    std::function<void(uint8_t)> watcher_;
    std::optional<uint8_t> waiting_;
    std::optional<uint8_t> shifting_;
    std::deque<uint8_t> arriving_;
    uint64_t sent_ns_ = kNever;
    uint64_t received_ns_ = kNever;
    uint32_t seen_ = 0;  // flags of the last read of SR, which a read of DR then clears
};

}  // namespace stator::chip
